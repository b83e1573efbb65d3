"""Network that estimates the pose of the needle in a crop, and the geometry around it, by PyTorch.

A crop is the image of a virtual camera that looks at the needle: B (b, 3, 3) turns directions of the real camera into those of
the virtual one, and may mirror X; its half field of view has the tangent h (b,). Crop coordinates are -1 to 1. The needle's
shape is its own mirror image by Z, so that a mirrored crop shows a needle, too."""
import torch
from torch import nn
from torch.nn import functional

POINTS = 9  # keypoints along the arc


def virtual_camera(rays, roll, mirrored):
    """B of cameras that look along rays (b, 3), turned by roll (b,) about them; mirrored: (b,) bool."""
    z = functional.normalize(rays, dim=1)
    x = functional.normalize(torch.tensor([1.0, 0, 0], device=z.device) - z * z[:, :1], dim=1)
    y = torch.cross(z, x, dim=1)
    c, s = torch.cos(roll)[:, None], torch.sin(roll)[:, None]
    x, y = c * x + s * y, c * y - s * x
    return torch.stack([torch.where(mirrored[:, None], -x, x), y, z], 1)


def mirror_of(b):
    """(b, 3, 3): what mirrored crops do to the needle's axes."""
    sign = torch.sign(torch.linalg.det(b.float()))
    ones = torch.ones_like(sign)
    return torch.diag_embed(torch.stack([ones, ones, sign], 1))


def crop(images, k, b, h, side):
    """images: (n, 3, height, width); k: (n, 3, 3). Returns (n, 3, side, side)."""
    line = (2 * torch.arange(side, device=b.device) + 1) / side - 1
    v, u = torch.meshgrid(line, line, indexing="ij")
    rays = torch.stack([u, v, torch.ones_like(u)], -1).reshape(-1, 3)
    rays = torch.cat([rays[None, :, :2] * h[:, None, None], rays[None, :, 2:].expand(len(b), -1, -1)], 2) @ b
    pixels = rays @ k.transpose(1, 2)
    pixels = pixels[..., :2] / pixels[..., 2:]
    size = torch.tensor([images.shape[3], images.shape[2]], device=b.device)
    grid = ((2 * pixels + 1) / size - 1).reshape(len(b), side, side, 2)
    return functional.grid_sample(images, grid.to(images.dtype), align_corners=False)


def rotation_of(six):
    """Rotations (b, 3, 3) of their first two columns (b, 6), made orthogonal."""
    x = functional.normalize(six[:, :3], dim=1)
    y = functional.normalize(six[:, 3:] - x * (x * six[:, 3:]).sum(1, keepdim=True), dim=1)
    return torch.stack([x, y, torch.cross(x, y, dim=1)], 2)


class Block(nn.Module):
    def __init__(self, inputs, outputs, stride):
        super().__init__()
        self.body = nn.Sequential(nn.Conv2d(inputs, outputs, 3, stride, 1, bias=False), nn.BatchNorm2d(outputs), nn.ReLU(inplace=True),
                                  nn.Conv2d(outputs, outputs, 3, 1, 1, bias=False), nn.BatchNorm2d(outputs))
        is_same = inputs == outputs and stride == 1
        self.skip = nn.Identity() if is_same else nn.Sequential(nn.Conv2d(inputs, outputs, 1, stride, bias=False), nn.BatchNorm2d(outputs))

    def forward(self, x):
        return functional.relu(self.body(x) + self.skip(x))


class Network(nn.Module):
    """An encoder with residual blocks, a decoder with a heat map for each keypoint, and a head for the pose."""

    def __init__(self, width=64):
        super().__init__()
        self.stem = nn.Sequential(nn.Conv2d(3, width, 7, 2, 3, bias=False), nn.BatchNorm2d(width), nn.ReLU(inplace=True), nn.MaxPool2d(3, 2, 1))
        widths = [width, width, 2 * width, 4 * width, 8 * width]
        self.stages = nn.ModuleList([nn.Sequential(Block(a, b, 1 if i == 0 else 2), Block(b, b, 1)) for i, (a, b) in enumerate(zip(widths, widths[1:]))])
        self.sides = nn.ModuleList([nn.Conv2d(each, 2 * width, 1) for each in widths[1:]])
        self.merge = nn.ModuleList([Block(2 * width, 2 * width, 1) for _ in range(3)])
        self.heat = nn.Conv2d(2 * width, 2 * POINTS, 1)
        self.pose = nn.Sequential(nn.Linear(8 * width + 3 * POINTS, 512), nn.ReLU(inplace=True), nn.Linear(512, 256), nn.ReLU(inplace=True),
                                  nn.Linear(256, 9))

    def forward(self, x):
        """Returns logarithms of heat maps (b, POINTS, side / 4, side / 4), keypoints (b, POINTS, 2) in crop coordinates, the
        logarithm of their scale of error, rotation (b, 3, 3), the
        place in crop coordinates (b, 2), and the logarithm of the depth in units of the crop."""
        x, levels = self.stem(x), []
        for stage in self.stages:
            x = stage(x)
            levels.append(x)
        y = self.sides[3](levels[3])
        for i in (2, 1, 0):
            y = self.merge[i](functional.interpolate(y, scale_factor=2.0, mode="nearest") + self.sides[i](levels[i]))
        maps = self.heat(y).float()
        heat = maps[:, :POINTS].flatten(2).log_softmax(2)
        share = heat.exp()
        side = maps.shape[2]
        line = (2 * torch.arange(side, device=x.device) + 1) / side - 1
        share = share.reshape(-1, POINTS, side, side)
        points = torch.stack([(share.sum(2) * line).sum(2), (share.sum(3) * line).sum(2)], 2)
        scale = (share * maps[:, POINTS:]).sum((2, 3)).clamp(-7, 2)
        values = self.pose(torch.cat([x.float().mean((2, 3)), points.flatten(1), scale], 1)).float()
        return heat.reshape(share.shape), points, scale, rotation_of(values[:, :6] + values.new_tensor([1, 0, 0, 0, 1, 0])), values[:, 6:8], values[:, 8]


def heat_loss(heat, points):
    """Cross entropy of heat maps, with targets that are spread over the four cells next to a point; those outside do not count."""
    side = heat.shape[2]
    cell = (points + 1) * side / 2 - 0.5
    corner = cell.floor()
    part, total = cell - corner, 0
    for dy in (0, 1):
        for dx in (0, 1):
            x, y = corner[..., 0].long() + dx, corner[..., 1].long() + dy
            inside = (x >= 0) & (x < side) & (y >= 0) & (y < side)
            at = heat.flatten(2).gather(2, (y.clamp(0, side - 1) * side + x.clamp(0, side - 1))[..., None])[..., 0]
            weight = (part[..., 0] if dx else 1 - part[..., 0]) * (part[..., 1] if dy else 1 - part[..., 1])
            total = total - (at * weight * inside).mean()
    return total


def project(rotation, translation, arc):
    """Points of the arc (POINTS, 3) over their depth: (b, POINTS, 2)."""
    at = arc @ rotation.transpose(1, 2) + translation[:, None]
    return at[..., :2] / at[..., 2:]


def skew(v):
    x, y, z = v.unbind(-1)
    zero = torch.zeros_like(x)
    return torch.stack([zero, -z, y, z, zero, -x, -y, x, zero], -1).reshape(*v.shape, 3)


def refine(rotation, translation, points, weights, arc, rounds=8):
    """Pose whose projected arc fits points (b, POINTS, 2), by Gauss-Newton steps. weights: of the squared distances. The given
    pose counts as an estimate with errors of 0.12 rad, and in millimetres of 1, 1 and 3."""
    rotation, translation, points, weights, arc = (each.double() for each in (rotation, translation, points, weights, arc))
    trust = torch.diag(arc.new_tensor([0.12, 0.12, 0.12, 1, 1, 3]) ** -2)
    moved = arc.new_zeros(len(rotation), 6)
    for _ in range(rounds):
        turned = arc @ rotation.transpose(1, 2)
        x, y, z = (turned + translation[:, None]).unbind(-1)
        zero = torch.zeros_like(z)
        slope = torch.stack([1 / z, zero, -x / z ** 2, zero, 1 / z, -y / z ** 2], -1).reshape(*z.shape, 2, 3)
        jacobian = torch.cat([-slope @ skew(turned), slope], -1)
        miss = torch.stack([x / z, y / z], -1) - points
        weighted = weights[..., None, None] * jacobian
        normal = (weighted.transpose(2, 3) @ jacobian).sum(1) + trust
        right = (weighted.transpose(2, 3) @ miss[..., None]).sum(1) + trust @ moved[..., None]
        step = -torch.linalg.solve(normal, right)[..., 0]
        rotation = torch.matrix_exp(skew(step[:, :3])) @ rotation
        translation = translation + step[:, 3:]
        moved = moved + step
    return rotation, translation
