#!/usr/bin/env python3
"""End-to-end test of containers/: what the files run exists, ports and names agree, and the pool's renderer answers probes and stops.

containers_test.py SOURCE FIRE3DV BULLET_ARM
"""
import os
import re
import signal
import subprocess
import sys
import tempfile
import urllib.request

import yaml

from harness import HANG_S, vulkan_environment
from image_reader import check

SOURCE, FIRE3DV, BULLET_ARM = sys.argv[1:]
PROGRAMS = {"fire3dv": FIRE3DV, "bullet_arm": BULLET_ARM}


def read(*names):
    with open(os.path.join(SOURCE, *names), encoding="utf-8") as file:
        return file.read()


def check_options(where, program, words):
    """Every option is one of the program's."""
    said = subprocess.run((PROGRAMS[program], "--help"), text=True, capture_output=True, check=True).stdout
    for word in words:
        if word.startswith("--"):
            check(re.search(rf"(^|[\s,]){re.escape(word)}\b", said), f"{where}: {program} has no option {word}")


def value_of(words, option):
    return words[words.index(option) + 1]


def compose():
    services = yaml.safe_load(read("containers", "compose.yaml"))["services"]
    users = {name: service for name, service in services.items() if name != "scene"}
    for name, service in users.items():
        check_options(name, service.get("entrypoint", ["fire3dv"])[0], service["command"])
    script = services["scene"]["command"][0]
    check_options("scene", "bullet_arm", re.search(r"bullet_arm ([^;]*)", script).group(1).split())
    shm, tls = services["renderer-shm"], services["renderer-tls"]
    check(value_of(shm["command"], "--listen") == value_of(services["simulator-shm"]["command"], "--to"), "names of shared memory differ")
    check(shm["ipc"] == "shareable" and services["simulator-shm"]["ipc"] == "service:renderer-shm", "the services do not share /dev/shm")
    port = value_of(tls["command"], "--listen").rsplit(":", 1)[1]
    check(value_of(services["simulator-tls"]["command"], "--to") == f"tls://renderer-tls:{port}", "the simulator connects elsewhere")
    check("subjectAltName=DNS:renderer-tls" in script, "the certificate has another name")
    for name in ("renderer-shm", "renderer-tls"):
        inner = services[name]["ports"][0].rsplit(":", 1)[1]
        check(value_of(services[name]["command"], "--metrics").endswith(":" + inner), f"{name}: --metrics has another port")
        for flag in ("--tls-cert", "--tls-key"):
            if flag in services[name]["command"]:
                check(value_of(services[name]["command"], flag) in script, f"{name}: nothing writes the file of {flag}")


def kubernetes():
    """Returns the arguments of the pool's renderer."""
    deployment, service = yaml.safe_load_all(read("containers", "kubernetes.yaml"))
    pod = deployment["spec"]["template"]
    [container] = pod["spec"]["containers"]
    words = container["args"]
    check_options("kubernetes.yaml", "fire3dv", words)
    ports = {port["name"]: port["containerPort"] for port in container["ports"]}
    check(value_of(words, "--listen") == f"tls://0.0.0.0:{ports['streams']}", "the port of streams differs")
    check(value_of(words, "--metrics") == f"0.0.0.0:{ports['metrics']}", "the port of metrics differs")
    check(pod["metadata"]["annotations"]["prometheus.io/port"] == str(ports["metrics"]), "Prometheus asks another port")
    for probe in ("startupProbe", "readinessProbe", "livenessProbe"):
        check(container[probe]["httpGet"] == {"path": "/metrics", "port": "metrics"}, f"{probe} asks elsewhere")
    check(service["spec"]["selector"] == deployment["spec"]["selector"]["matchLabels"] == pod["metadata"]["labels"], "labels differ")
    mounted = {mount["name"]: mount["mountPath"] for mount in container["volumeMounts"]}
    check(set(mounted) == {volume["name"] for volume in pod["spec"]["volumes"]}, "volumes and mounts differ")
    for path in (words[0], value_of(words, "--tls-cert"), value_of(words, "--tls-key")):
        check(os.path.dirname(path) in mounted.values(), f"nothing is mounted for {path}")
    check(container["resources"]["limits"]["nvidia.com/gpu"] == 1 and container["securityContext"]["readOnlyRootFilesystem"],
          "the renderer has no GPU of its own, or may write")
    return words


def run_renderer(words, folder):
    """Probes are answered, messages go to standard error alone, and SIGTERM ends the renderer."""
    places = {words[0]: "arm.glb", value_of(words, "--tls-cert"): "cert.pem", value_of(words, "--tls-key"): "key.pem",
              value_of(words, "--listen"): "tls://127.0.0.1:0", value_of(words, "--metrics"): "127.0.0.1:0"}
    subprocess.run((BULLET_ARM, "--write-scene", "arm.glb"), cwd=folder, check=True, capture_output=True)
    subprocess.run(("openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2", "-subj",
                    "/CN=renderer", "-keyout", "key.pem", "-out", "cert.pem"), cwd=folder, check=True, capture_output=True)
    command = [FIRE3DV, *[places.get(word, word) for word in words], "--size", "64x36", "--cache", "off"]
    with subprocess.Popen(command, cwd=folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=vulkan_environment()) as run:
        said, url = [], None
        for line in run.stderr:
            said.append(line)
            url = re.search(r"metrics at (http://\S+)", line)
            if url:
                break
        check(url, f"the renderer ended: {''.join(said)}")
        with urllib.request.urlopen(url.group(1), timeout=HANG_S) as answer:
            check(answer.status == 200 and b"fire3dv_" in answer.read(), "a probe is not answered")
        run.send_signal(signal.SIGTERM)
        out, err = run.communicate(timeout=HANG_S)
        check(run.returncode == 0 and out == "", f"exit status {run.returncode}, on standard output {out!r}; {err}")


def containerfile():
    text = read("containers", "Containerfile")
    targets = re.findall(r"^FROM \S+ AS (\w+)$", text, re.MULTILINE)
    for document in ("containers/Containerfile", "docs/containers.md"):
        for target in re.findall(r"--target (\w+)", read(document)):
            check(target in targets, f"{document}: there is no target {target}")
    entry_point = re.search(r'^ENTRYPOINT \["(\w+)"\]$', text, re.MULTILINE).group(1)
    check(entry_point in PROGRAMS, f"the entry point {entry_point} is no program")
    user = re.findall(r"^USER (.*)$", text, re.MULTILINE)
    check(user[-1] == "1000:1000" and "STOPSIGNAL SIGTERM" in text, f"the image runs as {user[-1]}")


with tempfile.TemporaryDirectory() as temporary:
    containerfile()
    compose()
    run_renderer(kubernetes(), temporary)
print("containers: passed")
