#!/usr/bin/env python3
"""Trains a small network on needle/train and prints its errors on needle/test, beside those that arXiv 2406.07328 states.
Needs PyTorch; a GPU is used if there is one. Weights are not stored."""
import argparse
import math
import mmap
import multiprocessing
import os
import sys
import time

import numpy as np

import bop
import poses
import shapes

#: Medians that the paper states, in degrees and millimetres.
PAPER = {"rotation": 7.74, "translation": 1.49, "MSSD": 1.43}
LEAST_VISIBLE = 0.1  # share of the needle; BOP's tasks leave out what is seen less
MARGIN = 2.0  # of a crop about the visible box
WEIGHT = 0.3  # of keypoints in the last fit: their errors are not independent


def read_images(labels):
    """(n, height, width, 3) uint8, decoded by all processors into memory that they share."""
    shape = bop.read_png(labels[0]["file"]).shape
    memory = mmap.mmap(-1, len(labels) * math.prod(shape))
    images = np.frombuffer(memory, np.uint8).reshape(len(labels), *shape)

    def work(first, step):
        for i in range(first, len(labels), step):
            images[i] = bop.read_png(labels[i]["file"])
    count = min(os.cpu_count() or 1, 32)
    workers = [multiprocessing.get_context("fork").Process(target=work, args=(i, count)) for i in range(count)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
        if worker.exitcode != 0:
            sys.exit("error: an image cannot be read: see above")
    return images[..., :3]


def read_set(folder):
    """Images and labels of a BOP set, as arrays."""
    number = bop.objects(folder).get("needle")
    if number is None:
        sys.exit(f"error: {folder}/dataset.json names no object \"needle\"; make.py makes such a set")
    labels = bop.labels(folder, number, LEAST_VISIBLE)
    if not labels:
        sys.exit(f"error: no image of {folder} shows a tenth of the needle")
    arrays = {key: np.array([each[key] for each in labels], np.float32) for key in ("k", "box", "rotation", "translation", "visible")}
    return {"images": read_images(labels), **arrays}, bop.vertices(folder, number)


class Trainer:
    def __init__(self, options, device):
        import network
        import torch
        self.torch, self.net, self.device, self.side = torch, network, device, options.crop
        torch.manual_seed(options.seed)
        if device == "cuda":
            torch.backends.cudnn.benchmark = True
        self.model = network.Network(options.width).to(device, memory_format=torch.channels_last)
        self.arc = torch.tensor(1000 * shapes.arc(np.linspace(0, 1, network.POINTS)), dtype=torch.float32, device=device)
        self.radius_mm = 1000 * shapes.NEEDLE_RADIUS_M

    def on_device(self, data):
        return {key: self.torch.from_numpy(np.ascontiguousarray(value)).to(self.device) for key, value in data.items()}

    def cameras(self, data, chosen, roll, mirrored, shift, zoom):
        """Virtual cameras B and h of crops about the boxes. shift: (n, 2) of the box, zoom: (n,)."""
        box, k = data["box"][chosen], data["k"][chosen]
        longer = box[:, 2:].max(1).values
        centre = box[:, :2] + 0.5 * (box[:, 2:] - 1) + shift * longer[:, None]
        rays = self.torch.cat([(centre - k[:, :2, 2]) / self.torch.stack([k[:, 0, 0], k[:, 1, 1]], 1), self.torch.ones_like(centre[:, :1])], 1)
        return self.net.virtual_camera(rays, roll, mirrored), 0.5 * MARGIN * zoom * longer.clamp(min=24) / k[:, 0, 0]

    def crops(self, data, chosen, b, h):
        images = data["images"][chosen].permute(0, 3, 1, 2).float() / 255  # halves would move crops by a tenth of a pixel
        return self.net.crop(images, data["k"][chosen], b, h, self.side)

    def changed_colors(self, images):
        """Brightness, gamma, white balance, noise and a hidden rectangle, at random."""
        torch, count = self.torch, len(images)
        uniform = lambda low, high, *shape: torch.empty(count, *shape, device=self.device).uniform_(low, high)
        images = images.clamp(0, 1) ** torch.exp(uniform(-0.35, 0.35, 1, 1, 1)) * uniform(0.7, 1.3, 1, 1, 1) * uniform(0.88, 1.12, 3, 1, 1)
        images = images + uniform(0, 0.04, 1, 1, 1) * torch.randn_like(images)
        line = torch.linspace(-1, 1, self.side, device=self.device)
        inside = [(line - uniform(-1.2, 1.2, 1)).abs() < uniform(0.0, 0.22, 1) for _ in range(2)]
        hidden = inside[0][:, None, :, None] & inside[1][:, None, None, :]
        return torch.where(hidden, uniform(0, 1, 3, 1, 1), images)

    def targets(self, data, chosen, b, h):
        """Pose in the virtual camera, and keypoints in crop coordinates."""
        rotation = b @ data["rotation"][chosen] @ self.net.mirror_of(b)
        translation = (b @ data["translation"][chosen][..., None])[..., 0]
        return rotation, translation, self.net.project(rotation, translation, self.arc) / h[:, None, None]

    def loss(self, data, chosen):
        torch, count = self.torch, len(chosen)
        uniform = lambda low, high, *shape: torch.empty(count, *shape, device=self.device).uniform_(low, high)
        b, h = self.cameras(data, chosen, uniform(-math.pi, math.pi), uniform(0, 1) < 0.5, uniform(-0.15, 0.15, 2), uniform(0.85, 1.2))
        with torch.no_grad():
            images = self.changed_colors(self.crops(data, chosen, b, h))
        true_rotation, true_translation, true_points = self.targets(data, chosen, b, h)
        heat, points, scale, rotation, place, depth = self.forward(images)
        away = (points - true_points).abs().sum(2)
        of_points = (away * torch.exp(-scale) + 2 * scale).mean()
        of_rotation = ((rotation - true_rotation) @ self.arc.t()).abs().mean() / self.radius_mm
        of_place = (place - true_translation[:, :2] / (true_translation[:, 2:] * h[:, None])).abs().mean()
        of_depth = (depth - torch.log(true_translation[:, 2] * h / self.radius_mm)).abs().mean()
        # The normal of the arc's plane: points alone leave its sign open, seen from far away.
        of_normal = (rotation[:, :, 2] - true_rotation[:, :, 2]).abs().mean()
        of_heat = self.net.heat_loss(heat, true_points)
        return 0.5 * of_heat + 0.2 * of_points + away.mean() + of_rotation + of_normal + of_place + 2 * of_depth, away.mean()

    def forward(self, images):
        with self.torch.autocast(self.device, dtype=self.torch.bfloat16, enabled=self.device == "cuda"):
            return self.model(images.contiguous(memory_format=self.torch.channels_last))

    def train(self, data, minutes, batch, rate):
        torch = self.torch
        optimizer = torch.optim.AdamW(self.model.parameters(), rate, weight_decay=0.02)
        self.model.train()
        started, steps, told = time.monotonic(), 0, 0
        while (share := (time.monotonic() - started) / (60 * minutes)) < 1:
            now = rate * min(1, (steps + 1) / 200) * 0.5 * (1 + math.cos(math.pi * share))
            for group in optimizer.param_groups:
                group["lr"] = now
            loss, away = self.loss(data, torch.randint(len(data["box"]), (batch,), device=self.device))
            optimizer.zero_grad(set_to_none=True)
            loss.backward()
            torch.nn.utils.clip_grad_norm_(self.model.parameters(), 2.0)
            optimizer.step()
            steps += 1
            if share >= told / 12:
                told += 1
                print(f"{100 * share:3.0f} %, {steps} steps of {batch} crops: loss {loss.item():.3f}, keypoints {50 * away.item():.2f} % of a crop",
                      flush=True)
        print(f"trained on {len(data['box'])} images, each seen {steps * batch / len(data['box']):.0f} times")

    def estimate(self, data, batch=64):
        """Poses of all images, by the head alone and by the fit to its keypoints: each crop is seen at two angles, each also
        mirrored."""
        torch, found = self.torch, []
        self.model.eval()
        with torch.no_grad():
            for first in range(0, len(data["box"]), batch):
                chosen = torch.arange(first, min(first + batch, len(data["box"])), device=self.device)
                found.append([each.cpu().double().numpy() for each in self._estimate(data, chosen)])
        return [np.concatenate(each) for each in zip(*found)]

    def _estimate(self, data, chosen):
        torch, count = self.torch, len(chosen)
        seen, first = [], None
        for roll in (0.0, math.pi / 2):
            for mirrored in (False, True):
                full = lambda value: torch.full((count,), value, device=self.device)
                b, h = self.cameras(data, chosen, full(roll), full(mirrored), torch.zeros(count, 2, device=self.device), full(1.0))
                _, points, scale, rotation, place, depth = self.forward(self.crops(data, chosen, b, h))
                if first is None:
                    z = self.radius_mm * torch.exp(depth) / h
                    translation = torch.cat([place * (z * h)[:, None], z[:, None]], 1)
                    first = b.transpose(1, 2) @ rotation, (b.transpose(1, 2) @ translation[..., None])[..., 0]
                rays = torch.cat([points * h[:, None, None], torch.ones_like(points[..., :1])], 2) @ b
                seen.append((rays[..., :2] / rays[..., 2:], torch.exp(-2 * scale).clamp(max=1e4) / h[:, None] ** 2))
        weights = torch.stack([weight for _, weight in seen])
        points = (torch.stack([each for each, _ in seen]) * weights[..., None]).sum(0) / weights.sum(0)[..., None]
        return *first, *self.net.refine(*first, points, WEIGHT * weights.mean(0), self.arc)


def print_tables(estimated, data, vertices):
    true = [data[key].astype(float) for key in ("rotation", "translation")]
    rows = [poses.table(*pair, *true, vertices) for pair in (estimated[:2], estimated[2:])]
    print(f"\nErrors on {len(true[0])} images of unseen sequences that show at least {100 * LEAST_VISIBLE:.0f} % of the needle, cut out by the\n"
          "box of its visible part, which is given:\n")
    print("| error | median | mean | median, without the fit | arXiv 2406.07328, median |\n|---|---|---|---|---|")
    for (name, unit, median, mean), (_, _, alone, _) in zip(rows[1], rows[0]):
        print(f"| {name}, {unit} | {median:.2f} | {mean:.2f} | {alone:.2f} | {PAPER.get(name, '')} |")
    print("\nThe paper's figures are of GDR-Net, another needle, other images and another camera: a comparison of methods they are not.")


def main():
    parser = argparse.ArgumentParser(description=__doc__.replace("\n", " "))
    parser.add_argument("folder", help="folder of make.py, with the sets train and test")
    parser.add_argument("--minutes", type=float, default=5.0, help="time to train, without reading and tests (default: %(default)s)")
    parser.add_argument("--batch", type=int, default=128, help="crops in a step (default: %(default)s)")
    parser.add_argument("--crop", type=int, default=256, help="side of a crop in pixels, a multiple of 32 (default: %(default)s)")
    parser.add_argument("--width", type=int, default=64, help="channels of the first layer (default: %(default)s)")
    parser.add_argument("--rate", type=float, default=1e-3, help="highest learning rate (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of first weights and crops (default: %(default)s)")
    options = parser.parse_args()
    if options.crop % 32 or options.crop < 64 or options.batch < 1 or options.width < 1 or not options.minutes > 0:
        parser.error("--crop is a multiple of 32 from 64 on; --batch, --width and --minutes are above 0")
    began = time.monotonic()
    try:
        (train, _), (test, vertices) = (read_set(os.path.join(options.folder, name)) for name in ("train", "test"))
    except (OSError, ValueError) as error:
        sys.exit(f"error: {error}; make.py makes the data set")
    print(f"{len(train['box'])} images to train with and {len(test['box'])} to test, read in {time.monotonic() - began:.0f} s", flush=True)
    try:
        import torch
    except ImportError:
        sys.exit("error: PyTorch is not installed (Debian: python3-torch; pip install torch)")
    device = "cuda" if torch.cuda.is_available() else "cpu"
    print(f"PyTorch {torch.__version__} on {torch.cuda.get_device_name() if device == 'cuda' else 'the CPU'}", flush=True)
    trainer = Trainer(options, device)
    trainer.train(trainer.on_device(train), options.minutes, options.batch, options.rate)
    print_tables(trainer.estimate(trainer.on_device(test)), test, vertices)


if __name__ == "__main__":
    main()
