"""Zip archives of the same bytes for the same contents: entries in order, one date, two modes."""
import datetime
import os
import tempfile
import zipfile

DIST_INFO = ".dist-info/"  # of a wheel: at the end, as the format recommends


def normalise(path, epoch_s):
    """Writes a zip file, such as a wheel, anew: dated epoch_s (UTC), mode 644, or 755 for what anybody may execute."""
    date = max(datetime.datetime.fromtimestamp(epoch_s, datetime.timezone.utc).timetuple()[:6], (1980, 1, 1, 0, 0, 0))
    handle, new = tempfile.mkstemp(dir=os.path.dirname(path) or ".")
    os.close(handle)
    with zipfile.ZipFile(path) as before, zipfile.ZipFile(new, "w", zipfile.ZIP_DEFLATED) as after:
        files = [each for each in before.infolist() if not each.is_dir()]
        for each in sorted(files, key=lambda info: (DIST_INFO in info.filename, info.filename.endswith("/RECORD"), info.filename)):
            entry = zipfile.ZipInfo(each.filename, date_time=date)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3  # Unix
            entry.external_attr = (0o100755 if (each.external_attr >> 16) & 0o111 else 0o100644) << 16
            after.writestr(entry, before.read(each))
    os.chmod(new, 0o644)
    os.replace(new, path)
