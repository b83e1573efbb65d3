#!/usr/bin/env python3
"""End-to-end test of start order, death, restart and absence of either side: the other goes on and reports the change."""
import os

from harness import TRANSPORTS, main, shown
from image_reader import PLACE_AT_REST, check, expect_square, place_of


def streams_of(name, epoch=None):
    """Returns a predicate: the image shows this stream, and no other epoch of it."""
    def predicate(frame):
        tags = [s for s in frame["streams"] if s["stream"] == name]
        return len(tags) == 1 and epoch in (None, tags[0]["epoch"])
    return predicate


def expect_stream_drawn(renderer, name, square="red", epoch=None, after=-1):
    frame = renderer.wait_frame(f"an image of {name}", streams_of(name, epoch), after)
    expect_square(renderer.picture(frame), square, frame_place(frame, name), frame["file"])
    return frame


def frame_place(frame, name):
    return place_of(shown(frame, name)["sequence"])


def renderer_first(test, transport):
    uri = test.fresh_uri(transport)
    renderer = test.renderer("--exit-when-done", listen=[uri])
    renderer.wait_frame("an image of the scene at rest", lambda f: f["streams"] == [])
    publisher = test.publisher(uri)
    publisher.do("stream 100")
    expect_stream_drawn(renderer, "arm")
    publisher.quit()
    renderer.expect_exit(0)
    check(renderer.find_err('stream "arm" ended'), "the renderer does not say that the stream ended")


def adapter_first(test, transport):
    uri = test.fresh_uri(transport)
    publisher = test.publisher(uri)
    status = publisher.do("publish 500")
    check(status["published"] == 500 and status["renderers"] == 0 and status["welcome"] == -1, f"status is {status}")
    publisher.do("stream 100")
    renderer = test.renderer("--exit-when-done", listen=[uri])
    frame = expect_stream_drawn(renderer, "arm")
    check(shown(frame, "arm")["sequence"] > 499, f"an old frame is shown: {frame}")
    publisher.wait_status("the renderer to be known", lambda s: s["renderers"] == 1 and s["welcome"] == 0)
    publisher.quit()
    renderer.expect_exit(0)


def adapter_rests(test, transport):
    """The renderer shows a last frame that was published before the renderer started."""
    uri = test.fresh_uri(transport)
    publisher = test.publisher(uri)
    publisher.do("publish 5")
    renderer = test.renderer(listen=[uri])
    frame = expect_stream_drawn(renderer, "arm")
    check(shown(frame, "arm")["sequence"] == 5, f"not the newest frame: {frame}")
    renderer.stop()


def adapter_restarted(test, transport, kill):
    uri = test.fresh_uri(transport)
    renderer = test.renderer(listen=[uri])
    renderer.uris()
    first = test.publisher(uri)
    first.do("stream 100")
    frame = expect_stream_drawn(renderer, "arm")
    if kill:
        first.kill()
    else:
        first.quit()
    second = test.publisher(uri)
    epoch = second.do("stream 100")["epoch"]
    check(epoch != shown(frame, "arm")["epoch"], "the epoch is the same after a restart")
    expect_stream_drawn(renderer, "arm", epoch=epoch, after=frame["frame"])
    check(renderer.find_err('stream "arm" ended'), "the renderer does not say that the first stream ended")
    renderer.stop()


def renderer_restarted(test, transport, kill):
    uri = test.fresh_uri(transport)
    publisher = test.publisher(uri)
    publisher.do("stream 100")
    first = test.renderer(listen=[uri])
    frame = expect_stream_drawn(first, "arm")
    if kill:
        first.kill()
    else:
        first.stop()
    second = test.renderer(listen=[uri])
    again = expect_stream_drawn(second, "arm", epoch=shown(frame, "arm")["epoch"])
    check(shown(again, "arm")["sequence"] > shown(frame, "arm")["sequence"], f"{again} is older than {frame}")
    check(publisher.alive(), "the adapter ended with its renderer")
    second.stop()


def described_anew(test, transport):
    uri = test.fresh_uri(transport)
    renderer = test.renderer(listen=[uri])
    publisher = test.publisher(uri)
    publisher.do("stream 100")
    frame = expect_stream_drawn(renderer, "arm")
    epoch = publisher.do("rest")["epoch"]
    publisher.do("stream 100")
    expect_stream_drawn(renderer, "arm", epoch=epoch, after=frame["frame"])
    renderer.stop()


def two_adapters(test, transport):
    uris = [test.fresh_uri(transport)]
    if transport == "shm":
        uris.append(test.fresh_uri(transport))  # a segment has one publisher
    renderer = test.renderer(listen=uris)
    left = test.publisher(uris[0], name="left", nodes=["red"])
    right = test.publisher(uris[-1], name="right", nodes=["green"])
    left.do("stream 50")
    right.do("stream 80")
    frame = renderer.wait_frame("an image of both", lambda f: shown(f, "left") and shown(f, "right"))
    picture = renderer.picture(frame)
    expect_square(picture, "red", frame_place(frame, "left"), "left")
    expect_square(picture, "green", frame_place(frame, "right"), "right")
    expect_square(picture, "blue", PLACE_AT_REST, "nobody's node")
    left.quit()
    frame = renderer.wait_frame("left to be gone", lambda f: not shown(f, "left") and shown(f, "right"), frame["frame"])
    picture = renderer.picture(frame)
    expect_square(picture, "red", PLACE_AT_REST, "a node given back")
    expect_square(picture, "green", frame_place(frame, "right"), "right, alone")
    renderer.stop()


def names(test, transport):
    """Unknown or contested nodes are reported on both sides; the others move."""
    uris = [test.fresh_uri(transport)]
    if transport == "shm":
        uris.append(test.fresh_uri(transport))
    renderer = test.renderer(listen=uris)
    first = test.publisher(uris[0], name="first", nodes=["no such node", "red"])
    first.do("stream 50")
    status = first.wait_welcome()
    check(status["welcome"] == 0 and status["unmatched"] == 1 and "no such node" in status["message"],
          f"the adapter hears: {status}")
    renderer.wait_err('stream "first".*no scene node is called "no such node"')
    first.do("stream 50")
    expect_stream_drawn(renderer, "first")
    second = test.publisher(uris[-1], name="second", nodes=["green", "red"])
    status = second.wait_welcome()
    check(status["welcome"] == 0 and "another stream drives" in status["message"] and "red" in status["message"],
          f"the second adapter hears: {status}")
    renderer.wait_err('stream "second".*another stream drives "red"')
    check(status["conflicting"] == 1 and status["contested"] == 0, f"the second adapter hears: {status}")
    status = first.wait_status("the first to hear who asks for its node", lambda s: s["contested"] == 1)
    check(status["conflicting"] == 0 and "another stream requests red" in status["message"], f"the first hears: {status}")
    third = test.publisher(uris[-1], name="third", nodes=["red"]) if transport != "shm" else None
    if third:
        third.wait_welcome()
        third.quit()
        check(first.do("status")["contested"] == 1, "the second still asks")
    first.do("stream 50")
    first.quit()
    second.wait_status("the node to be given to the second", lambda s: s["message"] == "accepted")
    second.do("stream 50")
    frame = renderer.wait_frame("the second alone", lambda f: len(f["streams"]) == 1 and shown(f, "second"))
    expect_square(renderer.picture(frame), "red", frame_place(frame, "second"), "the node that was given back")
    renderer.stop()


def two_frames(test, transport):
    """Streams with different bases, units and origins in one scene: the squares stand where a stream in metres puts them."""
    uris = [test.fresh_uri(transport)]
    if transport == "shm":
        uris.append(test.fresh_uri(transport))
    renderer = test.renderer(listen=uris)
    metres = test.publisher(uris[0], name="metres", nodes=["red"])
    millimetres = test.publisher(uris[-1], name="millimetres", nodes=["--millimetres", "green", "blue"])
    metres.do("stream 60")
    millimetres.do("stream 90")
    frame = renderer.wait_frame("both", lambda f: shown(f, "metres") and shown(f, "millimetres"))
    picture = renderer.picture(frame)
    expect_square(picture, "red", frame_place(frame, "metres"), "in metres, Y up")
    for square in ("green", "blue"):
        expect_square(picture, square, frame_place(frame, "millimetres"), "in millimetres, Z up")
    millimetres.quit()
    frame = renderer.wait_frame("metres alone", lambda f: not shown(f, "millimetres"), frame["frame"])
    expect_square(renderer.picture(frame), "green", PLACE_AT_REST, "a node given back")
    renderer.stop()


def no_adapter(test, transport):
    uri = test.fresh_uri(transport)
    renderer = test.renderer("--frames", "4", listen=[uri])
    renderer.expect_exit(0)
    frames = renderer.frames()
    check([f["frame"] for f in frames] == [0, 1, 2, 3] and all(f["streams"] == [] for f in frames), f"{frames}")
    picture = renderer.picture(frames[-1])
    for square in ("red", "green", "blue"):
        expect_square(picture, square, PLACE_AT_REST, "at rest")


def waits_for_stream(test, transport):
    """--wait-for-stream: images are written and counted from the first pose frame on."""
    uri = test.fresh_uri(transport)
    stats = test.path("stats.csv")
    renderer = test.renderer("--wait-for-stream", "60", "--frames", "3", "--stats", stats, listen=[uri])
    renderer.uris()
    publisher = test.publisher(uri)
    publisher.do("stream 100")
    renderer.expect_exit(0)
    frames = renderer.frames()
    check([f["frame"] for f in frames] == [0, 1, 2], f"{frames}")
    for frame in frames:
        check(streams_of("arm")(frame), f"an image without the stream was written: {frame}")
    expect_square(renderer.picture(frames[0]), "red", frame_place(frames[0], "arm"), "the first image")
    with open(stats, encoding="utf-8") as file:
        rows = [line.split(",")[0] for line in file]
    check(rows == ["frame", "0", "1", "2"], f"rows of --stats: {rows}")


def any_stream_timeout(test):
    uris = [test.fresh_uri("tcp"), test.fresh_uri("shm")]
    renderer = test.renderer("--wait-for-stream", "0.2", "--frames", "3", listen=uris)
    renderer.expect_exit(1)
    check(renderer.find_err(f"no pose frame arrived at {uris[0]}, {uris[1]} within 0.2 s; start a simulator"),
          "the error does not name the URIs")
    check(not renderer.frames(), "images were written")


def any_no_listen(test):
    renderer = test.renderer("--frames", "2")
    renderer.expect_exit(0)
    check(len(renderer.frames()) == 2 and os.path.exists(os.path.join(renderer.folder, "frame_000001.png")), "no images")


def any_two_renderers(test):
    uri = test.fresh_uri("shm")
    publisher = test.publisher(uri)
    publisher.do("stream 100")
    first = test.renderer(listen=[uri])
    second = test.renderer(listen=[uri])
    frame = expect_stream_drawn(first, "arm")
    expect_stream_drawn(second, "arm")
    publisher.wait_status("both renderers to be known", lambda s: s["renderers"] == 2)
    publisher.do("stream 100")
    first.kill()
    expect_stream_drawn(second, "arm", after=len(second.frames()))
    publisher.wait_status("one renderer to be left", lambda s: s["renderers"] == 1)
    check(frame and publisher.alive(), "the adapter ended")
    publisher.quit()
    second.stop()


def any_all_transports(test):
    """One renderer listens on all transports."""
    renderer = test.renderer(listen=[test.fresh_uri("shm"), "tcp://127.0.0.1:0", "udp://127.0.0.1:0"])
    uris = renderer.uris(3)
    publishers = [test.publisher(uri, name=uri[:3], nodes=[node]) for uri, node in zip(uris, ("red", "green", "blue"))]
    for publisher in publishers:
        publisher.do("stream 60")
    frame = renderer.wait_frame("an image of all three", lambda f: len(f["streams"]) == 3)
    picture = renderer.picture(frame)
    for name, node in zip(TRANSPORTS, ("red", "green", "blue")):
        expect_square(picture, node, frame_place(frame, name), name)
    renderer.stop()


def cases():
    result = {"any_no_listen": any_no_listen, "any_two_renderers": any_two_renderers,
              "any_all_transports": any_all_transports, "any_stream_timeout": any_stream_timeout}
    for transport in TRANSPORTS:
        for run in (renderer_first, adapter_first, adapter_rests, two_adapters, names):
            result[f"{transport}_{run.__name__}"] = lambda test, t=transport, r=run: r(test, t)
        for run in (described_anew, two_frames, no_adapter, waits_for_stream):
            result[f"streams_{transport}_{run.__name__}"] = lambda test, t=transport, r=run: r(test, t)
        for run in (adapter_restarted, renderer_restarted):
            for kill in (False, True):
                result[f"{transport}_{run.__name__}{'_killed' if kill else ''}"] = (
                    lambda test, t=transport, r=run, k=kill: r(test, t, k))
    return result


if __name__ == "__main__":
    main(cases(), ["fire3dv", "publisher"], plain_images=True)
