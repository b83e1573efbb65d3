// Makers of the layouts of all formats.
#pragma once

#include <memory>

#include "renderer/dataset/layouts/layout.h"

namespace fire3dv::dataset {

// BOP, one scene for each camera: train/SCENE/{rgb,depth,mask,mask_visib}.
std::unique_ptr<Layout> make_bop_layout();
// COCO: images/ and annotations.json, with boxes, masks as compressed run lengths, and keypoints.
std::unique_ptr<Layout> make_coco_layout();
// YOLO detection: images/train, labels/train with one text file an image, data.yaml.
std::unique_ptr<Layout> make_yolo_layout();
// C3VD, a folder for each camera: 0_color.png, 0000_depth.tiff, 0000_normals.tiff, pose.txt.
std::unique_ptr<Layout> make_c3vd_layout();
// NumPy arrays, a folder for each camera: 000000.png, 000000.depth.npy and so on, 000000.json.
std::unique_ptr<Layout> make_folder_layout();
// HDF5: a file an image, and data.hdf5 over all.
std::unique_ptr<Layout> make_hdf5_layout();
// WebDataset: tar archives of samples, by size.
std::unique_ptr<Layout> make_webdataset_layout();
// LeRobot v3: one episode, with videos of colours and depth of each camera and Parquet tables.
std::unique_ptr<Layout> make_lerobot_layout();

}  // namespace fire3dv::dataset
