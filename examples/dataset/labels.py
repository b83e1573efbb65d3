"""Labels as a file that others read: COCO's list of instances."""
import json

import numpy as np


def run_lengths(mask):
    """COCO's uncompressed run-length code: column by column, how many 0, how many 1, how many 0 ..."""
    flat = mask.ravel(order="F")
    bounds = np.concatenate([[0], np.flatnonzero(np.diff(flat)) + 1, [flat.size]])
    counts = np.diff(bounds).tolist()
    return {"size": list(mask.shape), "counts": [0] + counts if flat[0] else counts}


class Coco:
    """instances.json in the making."""

    def __init__(self, classes):
        self.images, self.annotations = [], []
        self.categories = [{"id": number, "name": name} for name, number in classes.items()]

    def add(self, image, color_file, depth_file):
        """image: fire3dv.Image with instance_u32 and boxes2d. What has no class is no instance for COCO."""
        number = len(self.images) + 1
        self.images.append({
            "id": number, "file_name": color_file, "depth_file": depth_file, "width": image.width, "height": image.height,
            "sequence": image.sequence, "sim_time_ns": image.sim_time_ns, "world_from_camera": list(image.world_from_camera),
            "fx": image.fx, "fy": image.fy, "cx": image.cx, "cy": image.cy})
        instances = image["instance_u32"]
        for box in image["boxes2d"]:
            if box["semantic"] == 0:
                continue
            left, top, right, bottom = (int(box[side]) for side in ("min_x", "min_y", "max_x", "max_y"))
            self.annotations.append({
                "id": len(self.annotations) + 1, "image_id": number, "category_id": int(box["semantic"]), "iscrowd": 0,
                "bbox": [left, top, right - left, bottom - top], "area": int(box["pixels"]),
                "segmentation": run_lengths(instances == box["instance"])})

    def write(self, path):
        with open(path, "w", encoding="utf-8") as file:
            json.dump({"images": self.images, "annotations": self.annotations, "categories": self.categories}, file)
