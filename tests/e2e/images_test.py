"""End-to-end test of image requests over each link. A bar code in the scene proves that each image shows its frame, with
any number of open requests. Clients and renderers may die; impossible requests are refused.

images_test.py FIRE3DV [CASE...]; FIRE3DV_CLIENT_LIBRARY and PYTHONPATH lead to the Python package.
"""
import json
import os
import random
import signal
import subprocess
import sys
import time

import numpy

import barcode
import fire3dv
from harness import HANG_S, Program, main, vulkan_environment, wait_until
from image_reader import check, read_png
from prometheus import scrape, url_of

LINKS = ("shm", "tcp")
REQUESTS = 1000
STEPS = 150


def renderer_of(test, uri, *arguments, camera=barcode.CAMERA):
    scene = test.path("barcode.glb")
    barcode.write_scene(scene)
    command = [test.programs_at["fire3dv"], scene, "--validation", "--headless", "--tone-map", "none", "--cache", "off",
               "--background", "000000", "--size", f"{barcode.SIZE[0]}x{barcode.SIZE[1]}", "--camera", camera,
               "--listen", uri, *arguments]
    renderer = Program(test, "fire3dv", command, vulkan_environment())
    renderer.wait_err("listening on")
    return renderer


def stop(renderer):
    renderer.signal(signal.SIGTERM)
    renderer.expect_exit(0)


def open_stream(uri):
    stream = fire3dv.Stream(uri, adapter_name="bars")
    stream.describe(barcode.NAMES)
    return stream


def check_image(image, least, most):
    number = barcode.number_of(image["color_srgb8"])
    check(number == image.sequence, f"an image that says frame {image.sequence} shows {number}")
    check(least <= image.sequence <= most, f"frame {image.sequence} is not of {least} to {most}")
    check(image.sim_time_ns == 1000 * image.sequence, f"frame {image.sequence} says {image.sim_time_ns} ns")


def random_depth(test, link, *arguments, requests=REQUESTS):
    """Requests with random depth in flight, while the simulator goes on."""
    uri = test.fresh_uri(link)
    renderer = renderer_of(test, uri, "--on-request", *arguments)
    source = random.Random(11)
    with open_stream(uri) as stream:
        open_requests, asked, published = {}, 0, 0
        while asked < requests or open_requests:
            depth = source.randrange(24) if asked < requests else 0
            while asked < requests and len(open_requests) <= depth:
                if source.randrange(3):
                    published = stream.publish(1000 * (published + 1), barcode.poses_of(published + 1))
                request = stream.request_image(*barcode.SIZE, node=barcode.CAMERA)
                open_requests[request.id] = (request, max(published, 0))
                asked += 1
            wanted = source.choice([None, next(iter(open_requests.values()))[0]])
            image = stream.wait_image(HANG_S, wanted)
            _, least = open_requests.pop(image.request)
            if image.sequence == 0:
                check(least == 0, "an image is older than the wish for it")
                continue
            check_image(image, least, published)
    stop(renderer)


def paths(test, link):
    """A path-traced image shows one frame, colours and depth, although the simulator goes on while its paths are traced."""
    uri = test.fresh_uri(link)
    renderer = renderer_of(test, uri, "--on-request", "--render", "path", "--spp", "300", "--bounces", "1", "--ground", "off")
    with open_stream(uri) as stream:
        published = stream.publish(1000, barcode.poses_of(1))
        first = None
        for _ in range(4):
            request = stream.request_image(*barcode.SIZE, node=barcode.CAMERA, outputs=("color", "depth"))
            least, image, end = published, None, time.monotonic() + HANG_S
            while image is None:
                check(time.monotonic() < end, "no image")
                # The last frame stays, so that the next image has to show it.
                published = stream.publish(1000 * (published + 1), barcode.poses_of(published + 1))
                time.sleep(0.002)
                image = request.poll()
            if image.sequence == 0:  # the request came before the first frame
                continue
            check_image(image, least, published)
            is_near = numpy.isfinite(image["depth_f32"]) & (image["depth_f32"] < 1.5 * barcode.DISTANCE)
            color = numpy.repeat(numpy.where(is_near, 255, 0)[:, :, None], 4, axis=2)
            check(barcode.number_of(color) == image.sequence, f"the depth of frame {image.sequence} is of another one")
            if first is not None:
                check(image.sequence >= first, f"frame {image.sequence} came after {first}")
            first = image.sequence
        check(first, "no image shows a frame")
        # Two requests of one frame are drawn in turn.
        pair = [stream.request_image(*barcode.SIZE, node=barcode.CAMERA, when="every_nth") for _ in range(2)]
        for camera in pair:
            check_image(camera.wait(HANG_S), first, published)
    stop(renderer)


def lockstep(test, link, *arguments, steps=STEPS):
    uri = test.fresh_uri(link)
    renderer = renderer_of(test, uri, "--on-request", "--lockstep", *arguments)
    with open_stream(uri) as stream:
        with stream.request_image(*barcode.SIZE, node=barcode.CAMERA, when="every_nth") as camera:
            for number in range(1, steps + 1):
                [image] = stream.step(1000 * number, barcode.poses_of(number), [camera], HANG_S)
                check_image(image, number, number)
                check(image.lost == 0, f"{image.lost} images were lost in lockstep")
        # A request for a frame number may precede or follow the publication of the frame.
        for number in range(steps + 1, steps + 21, 2):
            ahead = stream.request_image(*barcode.SIZE, node=barcode.CAMERA, when="exactly", sequence=number)
            stream.publish(1000 * number, barcode.poses_of(number))
            check_image(ahead.wait(HANG_S), number, number)
            stream.publish(1000 * (number + 1), barcode.poses_of(number + 1))
            behind = stream.request_image(*barcode.SIZE, node=barcode.CAMERA, when="exactly", sequence=number + 1)
            check_image(behind.wait(HANG_S), number + 1, number + 1)
        late = stream.request_image(*barcode.SIZE, node=barcode.CAMERA, when="exactly", sequence=1)
        expect_refused(lambda: late.wait(HANG_S), "not shown any more")
    stop(renderer)


def same_as_file(test, link):
    """The returned image equals the file that the file sink writes of the same frame and camera."""
    uri = test.fresh_uri(link)
    folder = test.path("files")
    renderer = renderer_of(test, uri, "--lockstep", "--out", folder)
    with open_stream(uri) as stream:
        camera = stream.request_image(*barcode.SIZE, node=barcode.CAMERA, when="every_nth")
        w, h = barcode.SIZE
        fx = 4 * barcode.DISTANCE  # one unit is 4 pixels at that distance
        posed = stream.request_image(w, h, fx=fx, near_m=1, far_m=100, when="every_nth",
                                     parent_from_camera=[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, barcode.DISTANCE])
        kept = []
        for number in range(1, 9):
            pair = stream.step(1000 * number, barcode.poses_of(number), [camera, posed], HANG_S)
            kept.append([(image.sequence, numpy.array(image["color_srgb8"])) for image in pair])
            check(abs(pair[0].fx - fx) < 1e-3 and abs(pair[0].cx - (w - 1) / 2) < 1e-3,
                  f"the camera of the scene has fx {pair[0].fx}, cx {pair[0].cx}")
        check(stream.wait_ack(8, HANG_S * 1000), "the last frame was not shown")
    stop(renderer)
    for number, ((sequence, own), (_, posed_image)) in enumerate(kept):
        picture = read_png(os.path.join(folder, f"frame_{number:06d}.png"))
        check(picture.text["Sequence"] == str(sequence), f"file {number} shows {picture.text['Sequence']}, not {sequence}")
        rows = numpy.frombuffer(b"".join(picture.rows), numpy.uint8).reshape(picture.height, picture.width, 3)
        check((rows == own[:, :, :3]).all(), f"frame {sequence} differs from its file")
        check((own == posed_image).all(), f"frame {sequence}: by pose it differs from by name")


OUTPUTS = list(fire3dv.OUTPUTS)  # in the order of the file name suffixes
FILES = ["linear", "depth", "instance", "semantic", "normal", "motion"]


def same_bytes(one, other):
    return one.shape == other.shape and one.tobytes() == other.tobytes()


def all_outputs(test, link):
    """Returned planes and boxes equal the files that the file sink writes of the same frame and camera, bit for bit."""
    uri = test.fresh_uri(link)
    folder = test.path("files")
    renderer = renderer_of(test, uri, "--lockstep", "--out", folder, "--outputs",
                           ",".join(["color", *FILES, "boxes2d", "boxes3d"]), camera=barcode.OBLIQUE)
    kept = []
    with open_stream(uri) as stream:
        # Starts with frame 1: an image of the rest pose before it would add motion to the first frame.
        camera = stream.request_image(*barcode.SIZE, node=barcode.OBLIQUE, when="every_nth", sequence=1, outputs=OUTPUTS)
        for number in range(1, 5):
            [image] = stream.step(1000 * number, barcode.poses_of(number), [camera], HANG_S)
            check(image.outputs == tuple(OUTPUTS), f"asked for all outputs, got {image.outputs}")
            kept.append({output: numpy.array(image[output]) for output in OUTPUTS})
        check(stream.wait_ack(4, HANG_S * 1000), "the last frame was not shown")
    stop(renderer)
    with open(os.path.join(folder, "frames.jsonl"), encoding="utf-8") as file:
        lines = [json.loads(line) for line in file]
    for number, planes in enumerate(kept):
        seen = planes["instance_u32"]
        for name, output in zip(FILES, OUTPUTS[1:7]):
            of_file = numpy.load(os.path.join(folder, f"frame_{number:06d}.{name}.npy"))
            check(same_bytes(planes[output], of_file), f"frame {number + 1}: {output} differs from its file")
        check(len(planes["boxes2d"]) == barcode.BARS // 2, f"{len(planes['boxes2d'])} boxes, half of the bars are seen")
        for box, line in zip(planes["boxes2d"], lines[number]["boxes2d"]):
            check([int(box[k]) for k in ("min_x", "min_y", "max_x", "max_y")] == line["box"] and
                  int(box["instance"]) == line["instance"] and int(box["pixels"]) == (seen == box["instance"]).sum(),
                  f"frame {number + 1}: the box {box} is {line} in the file")
        for box, line in zip(planes["boxes3d"], lines[number]["boxes3d"]):
            check(int(box["instance"]) == line["instance"] and
                  numpy.allclose(box["world_from_box"].ravel(), line["world_from_box"], rtol=1e-6),
                  f"frame {number + 1}: the box {box} is {line} in the file")
        # Appearing bars come from behind the camera; the others do not move.
        came = numpy.isin(seen, [] if number == 0 else numpy.setdiff1d(seen, kept[number - 1]["instance_u32"]))
        check(came.any() == (number > 0) and numpy.isnan(planes["motion"][came]).all() and
              (planes["motion"][~came] == 0).all(), f"frame {number + 1}: motion is not what the bars did")


def many_cameras(test, link):
    """Cameras of several sizes and kinds are due together: each image has the same bytes as alone. Between them the
    renderer draws its own images, in some of the same sizes.
    """
    many_cameras_of(test, link)
    many_cameras_of(test, link, "--fxaa", "off")


def several_devices(test, link):
    """The same with two devices, here one device opened twice; the images of each request arrive in order."""
    many_cameras_of(test, link, "--fxaa", "off", "--devices", "0,0")
    lockstep(test, link, "--devices", "0,0", steps=40)
    random_depth(test, link, "--devices", "0,0", requests=200)
    uri = test.fresh_uri(link)
    renderer = renderer_of(test, uri, "--on-request", "--lockstep", "--devices", "0,0,0")
    with open_stream(uri) as stream:
        cameras = [stream.request_image(*barcode.SIZE, node=barcode.CAMERA, when="every_nth", outputs=["color_srgb8", "motion"])
                   for _ in range(5)]
        for number in range(1, 31):
            if number == 15:
                stream.add_node("one more")  # all devices replace their scene
            if number == 20:
                stream.set_base_color(barcode.NAMES[0], (1, 1, 1, 1))
            for image in stream.step(1000 * number, barcode.poses_of(number), cameras, HANG_S):
                check_image(image, number, number)
                check(image.lost == 0, f"{image.lost} images were lost in lockstep")
                moved = numpy.isnan(image["motion"]).any()
                check(moved == (number > 1) or number in (15, 16), f"frame {number}: motion {'' if moved else 'does not '}show who came")
    stop(renderer)


def many_cameras_of(test, link, *arguments):
    uri = test.fresh_uri(link)
    renderer = renderer_of(test, uri, "--lockstep", *arguments)
    fx = 4 * barcode.DISTANCE
    kinds = [(barcode.SIZE, ["depth_f32", "instance_u32"]), ((40, 30), ["depth_f32", "instance_u32"]),
             ((40, 30), ["color_srgb8"]), ((40, 30), ["color_srgb8", "normal", "boxes2d"]), ((33, 7), ["color_linear_f16"])]
    wanted = [(size, outputs, 0.5 * i) for i in range(5) for size, outputs in kinds]

    def ask(stream, size, outputs, x):
        return stream.request_image(*size, fx=fx, near_m=1, far_m=100, when="every_nth", outputs=outputs,
                                    parent_from_camera=[1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, barcode.DISTANCE])

    with open_stream(uri) as stream:
        together = [ask(stream, *one) for one in wanted]
        images = stream.step(1000, barcode.poses_of(1), together, HANG_S)
        kept = [{o: numpy.array(image[o]) for o in image.outputs} for image in images]
        del images
        for request in together:
            request.cancel()
        for number, one in enumerate(wanted):
            with ask(stream, *one) as request:
                [image] = stream.step(2000 + number, barcode.poses_of(1), [request], HANG_S)
                for output in one[1]:
                    check(same_bytes(kept[number][output], image[output]), f"{output} of {one} differs from that of it alone")
                    check(output == "boxes2d" or len(numpy.unique(image[output])) > 1, f"{output} of {one} is blank")
                del image
    stop(renderer)


LENSES = {"plumb_bob": (-0.12, 0.02, 0.004, -0.003, -0.001), "fisheye": (0.05, -0.02, 0.004, -0.0005)}


def distorted(lens, x, y):
    """Lens formulas of OpenCV's documentation."""
    k = LENSES[lens]
    if lens == "fisheye":
        r = numpy.hypot(x, y) + 1e-12
        t = numpy.arctan(r)
        scale = t * (1 + k[0] * t**2 + k[1] * t**4 + k[2] * t**6 + k[3] * t**8) / r
        return scale * x, scale * y
    r2 = x * x + y * y
    scale = 1 + k[0] * r2 + k[1] * r2**2 + k[4] * r2**3
    return (scale * x + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x), scale * y + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y)


def undistorted(lens, u, v):
    if lens == "fisheye":
        low, high = numpy.zeros_like(u), numpy.full_like(u, 1.5)
        for _ in range(60):  # bisection of the angle
            middle = (low + high) / 2
            short = distorted(lens, numpy.tan(middle), 0)[0] < numpy.hypot(u, v)
            low, high = numpy.where(short, middle, low), numpy.where(short, high, middle)
        scale = numpy.tan(low) / (numpy.hypot(u, v) + 1e-12)
        x, y = scale * u, scale * v
    else:
        x, y = u.copy(), v.copy()
        for _ in range(200):
            du, dv = distorted(lens, x, y)
            x, y = x + 0.5 * (u - du), y + 0.5 * (v - dv)
    check(max(abs(u - distorted(lens, x, y)[0]).max(), abs(v - distorted(lens, x, y)[1]).max()) < 1e-9, "the test is wrong")
    return x, y


def lenses(test, link):
    """Through a lens the bars appear at the positions of the formulas, within a pixel at their edges, and at the right
    depth.
    """
    uri = test.fresh_uri(link)
    renderer = renderer_of(test, uri, "--on-request")
    width, height, fx, fy, cx, cy, away = 160, 40, 60.0, 64.0, 77.0, 21.0, 10.0
    half_height = barcode.BARS * barcode.SIZE[1] / barcode.SIZE[0] / 2
    poses = numpy.array(barcode.poses_of(0x5a3c)).reshape(-1, 3, 4)
    with open_stream(uri) as stream:
        stream.publish(1000, poses)
        for lens, coefficients in LENSES.items():
            image = stream.request_image(
                width, height, fx=fx, fy=fy, cx=cx, cy=cy, near_m=1, far_m=100, lens=lens, lens_coefficients=coefficients,
                outputs=["color_srgb8", "depth_f32", "instance_u32", "boxes2d"],
                parent_from_camera=[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, away]).wait(HANG_S)
            check(image.lens == lens and numpy.allclose(image.lens_coefficients[:len(coefficients)], coefficients),
                  f"the image says {image.lens} {image.lens_coefficients}")
            v, u = numpy.mgrid[0:height, 0:width].astype(float)
            x, y = undistorted(lens, (u - cx) / fx, (v - cy) / fy)
            x, y = away * x, away * y
            want = numpy.zeros((height, width), int)
            for bar, pose in enumerate(poses):
                if pose[2, 3] == 0:
                    want[(abs(x - pose[0, 3]) <= 0.5) & (abs(y) <= half_height)] = 1 + bar
            got = image["instance_u32"].astype(int)
            # Only pixels away from edges: all neighbours have the same value.
            inner = numpy.ones_like(want, bool)
            for dy in (-1, 0, 1):
                for dx in (-1, 0, 1):
                    inner &= numpy.roll(want, (dy, dx), (0, 1)) == want
            inner[[0, -1], :] = inner[:, [0, -1]] = False
            seen = inner & (want != 0)
            check(seen.sum() > 100 and len(numpy.unique(want)) > 8, f"{lens}: the test sees too little")
            check((got[inner] == want[inner]).all(), f"{lens}: {(got != want)[inner].sum()} labels of {inner.sum()} are wrong")
            check((got != want).mean() < 0.02, f"{lens}: {(got != want).sum()} labels differ, more than edges can be off")
            check(numpy.allclose(image["depth_f32"][seen], away, rtol=1e-5) and numpy.isinf(image["depth_f32"][got == 0]).all(),
                  f"{lens}: depth is not {away}")
            check((image["color_srgb8"][seen][:, 0] > 250).all() and (image["color_srgb8"][inner & (want == 0)][:, 0] < 5).all(),
                  f"{lens}: colours are not where labels are")
            for box in image["boxes2d"]:
                ys, xs = numpy.nonzero(got == box["instance"])
                check([xs.min(), ys.min(), xs.max() + 1, ys.max() + 1] ==
                      [int(box[k]) for k in ("min_x", "min_y", "max_x", "max_y")], f"{lens}: box {box} is not that of the labels")
            del image
        expect_refused(lambda: stream.request_image(4000, 64, fx=1400, lens="fisheye").wait(HANG_S), "too wide")
        absurd = [1e12, -1e12, 1e12, 1e12, 1e12]
        for lens in LENSES:
            try:
                stream.request_image(64, 64, fx=30, lens=lens, lens_coefficients=absurd[:4 if lens == "fisheye" else 5]).wait(HANG_S)
            except fire3dv.RefusedError:
                pass
        check(renderer.alive(), "the renderer ended")
    stop(renderer)


def expect_refused(call, text):
    try:
        call()
    except fire3dv.RefusedError as refused:
        check(text in str(refused), f"refused for another reason: {refused}")
        return
    check(False, f"not refused: {text}")


def refusals(test, link):
    uri = test.fresh_uri(link)
    renderer = renderer_of(test, uri, "--on-request", "--metrics", "127.0.0.1:0", "--peer-limit", "requests=3")
    with open_stream(uri) as stream:
        stream.add_node("flat node", parent_from_node=[0] * 12)
        away = [1, 0, 0, 9e11, 0, 1, 0, 0, 0, 0, 1, 0]
        stream.add_node("away", parent_from_node=away)
        stream.add_node("far away", parent="away", parent_from_node=away)
        stream.publish(1000, barcode.poses_of(1))
        expect_refused(lambda: stream.request_image(8, 8, node="nobody").wait(HANG_S), '"nobody"')
        expect_refused(lambda: stream.request_image(8, 8, node="bar 1").wait(HANG_S), "no perspective camera")
        expect_refused(lambda: stream.request_image(8, 8, fx=8, node="flat node").wait(HANG_S), "flat")
        expect_refused(lambda: stream.request_image(8, 8, fx=8, node="far away").wait(HANG_S), "more than 1e12 m away")
        # Other requests are unaffected.
        with stream.request_image(*barcode.SIZE, node=barcode.CAMERA).wait(HANG_S) as image:
            check_image(image, 1, 1)
        counted = {"fire3dv_image_requests_refused_total": 4, "fire3dv_listener_images_sent_total": 1,
                   "fire3dv_listener_images_dropped_total": 0, "fire3dv_image_requests": 0}
        wait_until(lambda: f"the metrics {counted}",
                   lambda: all(scrape(url_of(renderer)).total(name) == count for name, count in counted.items()))
        # Open requests stop at the limit per peer; the limit is logged once.
        for _ in range(3):
            stream.request_image(8, 8, node=barcode.CAMERA, when="exactly", sequence=1000)
        for _ in range(2):
            expect_refused(lambda: stream.request_image(8, 8, node=barcode.CAMERA).wait(HANG_S), "--peer-limit requests=")
        try:
            stream.wait_image(0.5)
            check(False, "an image comes")
        except fire3dv.Timeout as timeout:
            check("within 0.5 s; 1 renderer is reached" in str(timeout), f"it says {timeout}")
        labels = {"fire3dv_peer_use": 3, "fire3dv_peer_limit": 3, "fire3dv_peer_refusals_total": 2}
        wait_until(lambda: f"the metrics {labels}",
                   lambda: all(scrape(url_of(renderer)).total(name, resource="requests") == count
                               for name, count in labels.items()))
        check(sum("--peer-limit requests=" in line for line in renderer.err) == 1, "the limit is not logged once")
    stop(renderer)


def ask_large(stream, side, count, sequence):
    """Requests images that become due together, at that frame."""
    return [stream.request_image(side, side, fx=side, near_m=1, far_m=100, sequence=sequence,
                                 parent_from_camera=[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, barcode.DISTANCE])
            for _ in range(count)]


def images_now(stream):
    count = 0
    try:
        while True:
            stream.wait_image(0)
            count += 1
    except fire3dv.Timeout:
        return count


def fair_turns_once(test, link):
    """A stream makes progress while another one always has large images due, and each of its images shows its frame."""
    uri, other = test.fresh_uri(link), test.fresh_uri(link)
    renderer = renderer_of(test, uri, "--on-request", "--listen", other)
    with open_stream(uri) as victim, fire3dv.Stream(other, adapter_name="greedy") as greedy:
        greedy.describe(["nothing"])
        with victim.request_image(*barcode.SIZE, node=barcode.CAMERA, when="every_nth") as camera:
            number, before, large = 0, 20, 0
            while large < 6:
                number += 1
                [image] = victim.step(1000 * number, barcode.poses_of(number), [camera], HANG_S)
                check_image(image, number, number)
                del image
                if number == before:
                    ask_large(greedy, 1024, 16, 1)
                    greedy.publish(1000, [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0])
                if number > before:
                    large += images_now(greedy)
        # Without fair scheduling all due large images would come between two images of the victim.
        made = number - before
    stop(renderer)
    return made >= 3 * large, f"{made} images of the victim beside {large} large ones"


def fair_turns(test, link):
    """Fair in one of three runs: a machine that does something else at the same time disturbs the order of turns."""
    results = []
    for _ in range(3):
        fair, what = fair_turns_once(test, link)
        results.append(what)
        if fair:
            return
    check(False, "; ".join(results))


def stop_request(test, link):
    """A renderer that is told to stop draws no further due images."""
    uri = test.fresh_uri(link)
    renderer = renderer_of(test, uri, "--on-request")
    with open_stream(uri) as stream:
        stream.publish(1000, barcode.poses_of(1))
        requests = ask_large(stream, 2048, 24, 2)  # a stream holds 8 images at once
        stream.publish(2000, barcode.poses_of(2))
        stream.wait_image(HANG_S)
        renderer.signal(signal.SIGTERM)
        came = 1
        while renderer.alive():
            came += images_now(stream)
        renderer.expect_exit(0)
        came += images_now(stream)
        check(came < len(requests) // 2, f"{came} of {len(requests)} images were drawn")


CLIENT = """
import sys, fire3dv, barcode
stream = fire3dv.Stream(sys.argv[1], adapter_name="bars")
stream.describe(barcode.NAMES)
for i in range(64):
    stream.request_image(*barcode.SIZE, node=barcode.CAMERA, when="every_nth")
held, number = [], 0
while True:
    number += 1
    stream.publish(1000 * number, barcode.poses_of(number))
    held = held[-9:] + [stream.wait_image()["color_srgb8"]]
    print(number, flush=True)
"""


def killed_clients(test, link):
    """Clients are killed with open requests and borrowed images; the next client finds clean state."""
    uri = test.fresh_uri(link)
    renderer = renderer_of(test, uri, "--on-request")
    for _ in range(4):
        client = subprocess.Popen([sys.executable, "-c", CLIENT, uri], stdout=subprocess.PIPE, text=True)
        try:
            for _ in range(3):
                check(client.stdout.readline(), "the client ended by itself")
        finally:
            client.kill()
            client.wait()
            client.stdout.close()
    with open_stream(uri) as stream:
        stream.publish(1000, barcode.poses_of(1))
        with stream.request_image(*barcode.SIZE, node=barcode.CAMERA).wait(HANG_S) as image:
            check_image(image, 1, 1)
    if link == "shm":
        check(not os.path.exists("/dev/shm/fire3dv." + uri.removeprefix("shm://")), "shared memory is left behind")
    check(renderer.alive(), "the renderer ended")
    stop(renderer)


def restarted_renderer(test, link):
    """A standing request outlives its renderer."""
    uri = test.fresh_uri(link)
    with open_stream(uri) as stream:
        camera = stream.request_image(*barcode.SIZE, node=barcode.CAMERA, when="every_nth")
        for number in (1, 2):
            renderer = renderer_of(test, uri, "--on-request")
            sequence = stream.publish(1000 * number, barcode.poses_of(number))
            image = camera.wait(HANG_S)
            while image.sequence < sequence:
                image = camera.wait(HANG_S)
            check_image(image, number, number)
            del image
            renderer.kill()
            wait_until("the renderer to be gone", lambda: stream.poll().renderers == 0)


def example(test, link):
    """Runs examples/camera_to_numpy."""
    uri = test.fresh_uri(link)
    renderer = renderer_of(test, uri, "--on-request")
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../examples/camera_to_numpy/camera_to_numpy.py")
    folder = test.path("arrays")
    program = Program(test, "camera_to_numpy", [
        sys.executable, script, "--to", uri, "--out", folder, "--images", "4", "--size", "64x48", "--center", "0,0,0",
        "--distance", str(barcode.DISTANCE), "--timeout", str(HANG_S)], dict(os.environ))
    program.expect_exit(0)
    arrays = [numpy.load(os.path.join(folder, f"color_{number:03}.npy")) for number in range(4)]
    check(all(a.shape == (48, 64, 4) and a.dtype == numpy.uint8 for a in arrays), "arrays of another shape or type")
    white = [int((a[..., 0] > 100).sum()) for a in arrays]
    check(white[0] >= 4, f"nothing is seen from the front: {white}")
    check(white[1] < white[0] and white[3] < white[0], f"the camera does not circle: {white}")
    stop(renderer)


if __name__ == "__main__":
    main({f"{case.__name__}_{link}": lambda test, c=case, l=link: c(test, l)
          for case in (random_depth, paths, lockstep, same_as_file, all_outputs, many_cameras, several_devices, lenses, refusals, fair_turns, stop_request, killed_clients, restarted_renderer, example)
          for link in LINKS}, ["fire3dv"])
