"""Test of the Python module with threads, forked children and kept images: exceptions instead of faults.

python_threads_test.py [FIRE3DV]    without the program: the cases without a renderer
"""
import os
import signal
import sys
import threading

import fire3dv

LOOPS = 30
FAULTS = []


def expect(condition, text):
    if not condition:
        raise AssertionError(text)


def thread(body):
    def run():
        try:
            body()
        except BaseException as fault:
            FAULTS.append(repr(fault))
    started = threading.Thread(target=run)
    started.start()
    return started


def described(uri=None):
    stream = fire3dv.Stream(uri or f"shm://test-threads-{os.getpid()}")
    stream.describe(["a"])
    stream.publish(0, fire3dv.pose((0, 0, 0)))
    return stream


def close_ends_waits():
    for _ in range(LOOPS):
        stream = described()
        request = stream.request_image(8, 8, fx=8)
        begun = threading.Barrier(3)

        def waits(call):
            begun.wait()
            try:
                call()
            except fire3dv.StateError as error:
                expect("closed" in str(error), error)
                return
            raise AssertionError("the wait ended without an exception")
        waiters = [thread(lambda: waits(lambda: request.wait(600))), thread(lambda: waits(lambda: stream.wait_ack(1, 600_000)))]
        begun.wait()
        stream.close()
        for waiter in waiters:
            waiter.join()
        request.close()  # after its stream: no error


def close_during_calls():
    """Calls of three threads, of which a fourth one closes the stream."""
    for _ in range(LOOPS):
        stream = described()

        def edits(name):
            try:
                for i in range(100_000):
                    stream.set_base_color(f"{name} {i % 20}", (0, 0, 0, 1))
                    stream.points(f"{name}/points", [(0, 0, i % 7)])
                    stream.scalars(name, i, {"value": i})
                    stream.poll()
            except fire3dv.StateError:
                return
            raise AssertionError("the stream was not closed")
        begun = [thread(lambda name=name: edits(name)) for name in ("a", "b", "c")]
        for i in range(20):
            stream.publish(i, fire3dv.pose((0, 0, i)))
        closers = [thread(stream.close) for _ in range(2)]
        for other in (*begun, *closers):
            other.join()
        expect(not stream.is_open, "it is open")


def sequences_are_unique():
    stream = described()
    sequences = []
    publishers = [thread(lambda: sequences.extend([stream.publish(i, fire3dv.pose((0, 0, i))) for i in range(500)]))
                  for _ in range(3)]
    for publisher in publishers:
        publisher.join()
    expect(sorted(sequences) == list(range(2, 1502)), "a sequence was returned twice")
    stream.close()


def signal_handler_closes():
    """A handler that runs inside of a wait of the same thread must neither hang nor fault."""
    stream = described()
    request = stream.request_image(8, 8, fx=8)
    signal.signal(signal.SIGALRM, lambda *_: stream.close())
    signal.setitimer(signal.ITIMER_REAL, 0.05)
    try:
        request.wait(600)
    except fire3dv.StateError:
        pass
    else:
        raise AssertionError("the wait went on")
    expect(not stream.is_open, "it is open")


def child_is_refused():
    """A child forked while another thread holds the stream: a sentence, and a normal end."""
    stream = described()
    waiter = thread(lambda: stream.wait_ack(1, 1_000))
    for _ in range(5):
        child = os.fork()
        if child == 0:
            try:
                stream.publish(1, fire3dv.pose((0, 0, 0)))
            except fire3dv.StateError as error:
                told = "forked" in str(error)
            stream.close()
            os._exit(0 if told and not stream.is_open else 1)
        expect(os.waitpid(child, 0)[1] == 0, "the child's call was not refused")
    waiter.join()
    expect(stream.publish(1, fire3dv.pose((0, 0, 0))) == 2, "the parent's stream has ended")
    stream.close()


def kept_images(program):
    """A program that keeps every image, and arrays of closed ones."""
    with open("threads_test.gltf", "w") as file:
        file.write('{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"name": "a"}]}')
    with fire3dv.Renderer("threads_test.gltf", program=program) as renderer, renderer.stream() as stream:
        stream.describe(["a"])
        cameras = [stream.request_image(16, 8, fx=8, when="every_nth", outputs=["depth"]) for _ in range(2)]
        kept = []
        for frame in range(30):
            images = stream.step(frame, fire3dv.pose((0, 0, 0)), cameras)
            expect([image.sequence for image in images] == [frame + 1] * 2, "an image of another frame")
            kept += [images[0].depth, images[1]]
            images[0].close()
        # Another thread closes images while this one reads them.
        readable = [image for image in kept if isinstance(image, fire3dv.Image)]
        closer = thread(lambda: [image.close() for image in readable])
        for image in readable:
            try:
                expect(image.depth.shape == (8, 16), "another shape")
            except fire3dv.StateError:
                pass
        closer.join()
    os.remove("threads_test.gltf")


for case in (close_ends_waits, close_during_calls, sequences_are_unique, signal_handler_closes, child_is_refused):
    case()
    expect(not FAULTS, f"{case.__name__}: {FAULTS}")
    print(case.__name__, "ok", flush=True)
if len(sys.argv) > 1:
    kept_images(sys.argv[1])
    expect(not FAULTS, FAULTS)
    print("kept_images ok")
