# MJCF: files and elements, assets, and the posed scene.
fire3dv_library(fire3dv_mjcf_scene
  SOURCES mjcf/scene/add_mjcf.cpp mjcf/scene/mjcf_appearance.cpp mjcf/scene/mjcf_names.cpp mjcf/scene/tendon_frames.cpp mjcf/scene/view_frame.cpp
  LINK fire3dv_convert_glb)
fire3dv_library(fire3dv_mjcf
  SOURCES mjcf/assets/builtin_mesh.cpp mjcf/assets/convex_hull.cpp mjcf/assets/mesh_data.cpp mjcf/assets/mesh_inertia.cpp
          mjcf/assets/mjcf_height_field.cpp mjcf/assets/mjcf_mesh.cpp mjcf/assets/mjcf_texture.cpp
          mjcf/assets/obj_format.cpp mjcf/assets/png_pixels.cpp mjcf/assets/sky_image.cpp mjcf/assets/texture_pattern.cpp
          mjcf/bodies/mjcf_joints.cpp mjcf/deformable/composite.cpp mjcf/deformable/composite_bodies.cpp mjcf/deformable/composite_cable.cpp
          mjcf/deformable/composite_parts.cpp mjcf/deformable/flex_shape.cpp mjcf/deformable/mjcf_composite.cpp
          mjcf/deformable/mjcf_flexcomp.cpp mjcf/deformable/mjcf_flexes.cpp
          mjcf/deformable/mjcf_skins.cpp mjcf/deformable/skin_data.cpp
          mjcf/bodies/mjcf_bodies.cpp mjcf/bodies/mjcf_kinematics.cpp mjcf/bodies/mjcf_objects.cpp mjcf/assets/mjcf_source.cpp mjcf/bodies/mjcf_tendons.cpp
          mjcf/bodies/mjcf_tracking.cpp mjcf/read_mjcf.cpp mjcf/bodies/tendon_wrap.cpp
          mjcf/xml/mjcf_attributes.cpp mjcf/xml/mjcf_element.cpp mjcf/xml/mjcf_files.cpp
  LINK fire3dv_mjcf_scene fire3dv_description_files PkgConfig::tinyxml2)
