"""Cases of tools/bare_wheel.py: what is odd about a machine, and what `fire3dv demo` must do there."""
from dataclasses import dataclass, field
from typing import Dict, Optional, Sequence

USERS = {"user": 1000, "other": 1001}
HOME = "/home/user"
PIP_OPTIONS = "--quiet --no-index --disable-pip-version-check"
NO_VENV_PIP = f"PIP_BREAK_SYSTEM_PACKAGES=1 python3 $(echo /usr/share/python-wheels/pip-*.whl)/pip install {PIP_OPTIONS}"
DEMO = "demo --size 160x90"
PLAIN_DEMO = f"cd ~ && venv/bin/fire3dv {DEMO}"
WHEEL, CPU_WHEEL = "/wheels/fire3dv-*.whl", "/wheels/fire3dv_cpu-*.whl"
ROBOT = ("""printf '<robot name="own"><link name="base"><visual><geometry><box size="0.4 0.4 0.1"/></geometry></visual></link>"""
         """<link name="arm"><visual><origin xyz="0 0 0.3"/><geometry><cylinder radius="0.05" length="0.6"/></geometry></visual></link>"""
         """<joint name="shoulder" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>"""
         """<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>' > robot.urdf""")


def into(folder, names=f"{WHEEL} {CPU_WHEEL}", before=""):
    """Command that makes a virtual environment in a folder, and installs into it."""
    return f"{before}python3 -m venv --system-site-packages {folder} && {folder}/bin/pip install {PIP_OPTIONS} {names}"


@dataclass
class Case:
    name: str
    what: str
    command: str = PLAIN_DEMO
    install: str = ""  # command; "": the machine of the case plain, installed and with its caches
    prepare: str = ""  # command of root, before the demo
    environment: Dict[str, Optional[str]] = field(default_factory=dict)  # None: not set
    user: int = USERS["user"]
    shm: Optional[str] = "50%"
    read_only: bool = False
    images: str = f"{HOME}/fire3dv-demo/frame_*.png"
    image_count: int = 16
    status: int = 0
    says: Sequence[str] = ()
    says_not: Sequence[str] = ()


LONG = "~/" + "/".join(["a_folder_with_a_long_name_" + 40 * "x"] * 8)
ODD = "~/'it'\\''s a Ünï 机器人 folder'"
NO_IMAGES = {"images": "", "image_count": 0}

_LIST = [
    Case("plain", "a virtual environment, no GPU, nothing cached", install=into("~/venv"), command="cd ~ && venv/bin/fire3dv demo"),
    Case("cached", "the second start"),
    Case("no-driver", "no GPU, and without fire3dv-cpu: the message names its file", install=into("~/venv", WHEEL), status=1,
         says=["fire3dv_cpu-*.whl"], says_not=["pip install fire3dv"], **NO_IMAGES),
    Case("read-only", "a read-only file system, except /tmp: images go there", read_only=True,
         images="/tmp/fire3dv-demo-*/frame_*.png", says=["/tmp/fire3dv-demo-"]),
    Case("nothing-writable", "a read-only file system, with /tmp", read_only=True, prepare="chmod 755 /tmp", status=1, says=["TMPDIR"],
         **NO_IMAGES),
    Case("no-shm", "no /dev/shm: TCP instead", shm=None, says=["over TCP instead"]),
    Case("shm-1m", "/dev/shm of 1 MB: TCP instead", shm="1m", says=["over TCP instead"]),
    Case("shm-64m", "/dev/shm of 64 MB, as in a container", shm="64m", says_not=["TCP"]),
    Case("no-home", "HOME is not set", environment={"HOME": None}, command=f"cd {HOME} && {HOME}/venv/bin/fire3dv {DEMO}"),
    Case("home-missing", "HOME does not exist, nor can be made", environment={"HOME": "/nonexistent"},
         command=f"cd {HOME} && {HOME}/venv/bin/fire3dv {DEMO}"),
    Case("unknown-user", "a user id without name and home, as in OpenShift", environment={"HOME": None}, user=12345,
         command=f"cd /tmp && {HOME}/venv/bin/fire3dv {DEMO}", images="/tmp/fire3dv-demo/frame_*.png"),
    Case("locale-tr", "Turkish, whose i has other capitals", environment={"LC_ALL": "tr_TR.UTF-8"},
         prepare="localedef -i tr_TR -f UTF-8 tr_TR.UTF-8"),
    Case("locale-c", "LC_ALL=C, and a time zone of quarters", environment={"LC_ALL": "C", "TZ": "Asia/Kathmandu"}),
    Case("locale-broken", "a locale and a time zone that do not exist", environment={"LC_ALL": "xx_YY.UTF-99", "TZ": ":/no/such/zone"}),
    Case("odd-folder", "folders with blanks, an apostrophe and other scripts", install=into(ODD),
         command=f"cd {ODD} && bin/fire3dv {DEMO}", images=f"{HOME}/it's*/fire3dv-demo/frame_*.png"),
    Case("long-path", "a path of 570 bytes", install=into(LONG, before=f"mkdir -p {LONG} && "),
         command=f"cd {LONG} && bin/fire3dv {DEMO}", images=f"{LONG.replace('~', HOME)}/fire3dv-demo/frame_*.png"),
    Case("isolated", "python -I -m fire3dv", command=f"cd ~ && venv/bin/python -I -m fire3dv {DEMO}"),
    Case("module", "python -m fire3dv", command=f"cd ~ && venv/bin/python -m fire3dv {DEMO}"),
    Case("pip-user", "pip install --user", install=f"{NO_VENV_PIP} --user {WHEEL} {CPU_WHEEL}",
         command=f"cd ~ && .local/bin/fire3dv {DEMO}"),
    Case("pip-target", "pip install --target", install=f"{NO_VENV_PIP} --no-deps --target ~/target {WHEEL} {CPU_WHEEL}",
         command=f"cd ~ && PYTHONPATH=$HOME/target python3 -m fire3dv {DEMO}"),
    Case("umask-077", "umask 077", install=into("~/venv", before="umask 077 && "), command=f"umask 077 && {PLAIN_DEMO}"),
    Case("two-users", "two users at once, with one installation of root", user=0, environment={"HOME": None}, install=into("/opt/fire3dv"),
         command="status=0; for name in user other; do /usr/sbin/runuser -u $name -- env HOME=/home/$name sh -c "
                 f"'cd ~ && /opt/fire3dv/bin/fire3dv {DEMO}' & pids=\"$pids $!\"; done; "
                 "for pid in $pids; do wait $pid || status=1; done; exit $status",
         images="/home/*/fire3dv-demo/frame_*.png", image_count=32),
    Case("uninstall", "pip uninstall leaves nothing", install=into("~/venv"),
         command=f"{PLAIN_DEMO} && venv/bin/pip uninstall --quiet --yes fire3dv fire3dv-cpu && ! find venv -path '*fire3dv*' | grep . "
                 "&& echo nothing is left"),
    Case("programs", "every program's --help and --version", **NO_IMAGES,
         command="cd ~ && for p in venv/bin/fire3dv* venv/bin/bullet_arm; do $p --help > /dev/null && $p --version || exit 1; done"),
    Case("own-robot", "a picture of a URDF file", images=f"{HOME}/out/frame_*.png", image_count=1,
         command=f"cd ~ && {ROBOT} && venv/bin/fire3dv robot.urdf --headless --frames 1 --out out"),
    Case("record", "record, inspect, replay and convert", image_count=1, images=f"{HOME}/out/frame_*.png", command=(
        "cd ~ && PATH=$HOME/venv/bin:$PATH && bullet_arm --write-scene arm.glb && { bullet_arm --to shm://r --realtime --seconds 3 & "
        "fire3dv-record --from shm://r --out run.mcap --attach arm.glb & sleep 5; kill $!; wait; } && fire3dv --replay run.mcap --headless "
        "--frames 1 --out out --size 160x90 && fire3dv-convert arm.glb --list > /dev/null")),
    Case("python", "an image as NumPy array, by fire3dv.Renderer", **NO_IMAGES, says=["(48, 64, 4) True"], command=(
        f"cd ~ && {ROBOT} && venv/bin/python -c 'import fire3dv\nwith fire3dv.Renderer(\"robot.urdf\") as r, r.stream() as s:\n"
        " s.describe([\"arm\"])\n view = fire3dv.look_at(eye=(2, 1, 2), target=(0, 0.3, 0))\n"
        " q = s.request_image(64, 48, fx=60, parent_from_camera=view)\n s.publish(0, fire3dv.pose((0, 0, 0), quaternion=(0, 0, 0, 1)))\n"
        " image = q.wait()\n print(image.color.shape, image.color[..., :3].std() > 1)'")),
]
CASES = {case.name: case for case in _LIST}
