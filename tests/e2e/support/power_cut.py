"""Model of a disk after a power cut, from a journal of lose_unsynced.c.

Flushed bytes are present. Of later writes any subset is present, each whole or in part. Changes of a folder reach the
disk in order, and those after the last flush of the folder may be missing. A flush of a file excludes its name.
"""
import collections
import os
import struct

CREATE, WRITE, TRUNCATE, FLUSH, FLUSH_FOLDER, RENAME, UNLINK = range(1, 8)
HEAD = struct.Struct("=IIIIQQQ")


class Operation:
    def __init__(self, head, paths, data):
        self.kind, self.inode, self.offset = head[0], head[4], head[5]
        self.path, self.second_path, self.data = *paths, data


def operations_of(journal):
    with open(journal, "rb") as file:
        data = file.read()
    result, at = [], 0
    while at + HEAD.size <= len(data):
        head = HEAD.unpack_from(data, at)
        at += HEAD.size
        texts = []
        for length in (head[1], head[2]):
            texts.append(data[at:at + length].decode())
            at += length
        result.append(Operation(head, texts, data[at:at + head[6]]))
        at += head[6]
    return result


class File:
    def __init__(self):
        self.flushed, self.pending = b"", []

    @staticmethod
    def apply(content, operation, data):
        if operation.kind == TRUNCATE:
            return content[:operation.offset].ljust(operation.offset, b"\0")
        content = content.ljust(operation.offset, b"\0")
        return content[:operation.offset] + data + content[operation.offset + len(data):]

    def content(self):
        result = self.flushed
        for operation in self.pending:
            result = self.apply(result, operation, operation.data)
        return result

    def flush(self):
        self.flushed, self.pending = self.content(), []

    def after_cut(self, random):
        result = self.flushed
        fate = random.choice(("nothing", "prefix", "subset"))
        kept = random.randint(0, len(self.pending))
        for number, operation in enumerate(self.pending):
            if fate == "nothing" or (fate == "prefix" and number > kept) or (fate == "subset" and random.random() < 0.5):
                continue
            is_whole = fate == "prefix" and number < kept
            length = len(operation.data) if is_whole else random.randint(0, len(operation.data))
            result = self.apply(result, operation, operation.data[:length])
        return result


class Disk:
    """Folders with files. A file is renamed within its folder."""

    def __init__(self):
        self.files, self.names, self.flushed_names = {}, {}, {}
        self.pending = collections.defaultdict(list)  # pending changes of each folder

    def do(self, operation):
        kind, name = operation.kind, operation.path
        if kind == CREATE:
            self.files[operation.inode] = File()
            self._change(name, self.files[operation.inode])
        elif kind in (WRITE, TRUNCATE):
            self.files[operation.inode].pending.append(operation)
        elif kind == FLUSH:
            self.files[operation.inode].flush()
        elif kind == FLUSH_FOLDER:
            for change in self.pending.pop(name, []):
                self.flushed_names.update(change)
        elif kind == RENAME:
            file = self.names[name]
            self._change(name, None, operation.second_path, file)
        elif kind == UNLINK:
            self._change(name, None)

    def _change(self, *names_and_files):
        change = dict(zip(names_and_files[::2], names_and_files[1::2]))
        self.names.update(change)
        self.pending[os.path.dirname(names_and_files[0])].append(change)

    def after_cut(self, random):
        """Returns the contents by the last component of the path."""
        names = dict(self.flushed_names)
        for changes in self.pending.values():
            for change in changes[:random.randint(0, len(changes))]:
                names.update(change)
        return {os.path.basename(name): file.after_cut(random) for name, file in names.items() if file}
