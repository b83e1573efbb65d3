// Radiance along a ray that passes blended and transmissive surfaces: refracted at volumes (KHR_materials_volume),
// straight through others. Each surface in front of it adds its own light, shaded like every hit.
#ifndef FIRE3DV_RAY_THROUGH_GLSL
#define FIRE3DV_RAY_THROUGH_GLSL
#include "path/media.glsl"

const uint kMaxSurfaces = 8;  // of a ray; the environment is taken behind them

uint ray_channel;  // colour channel of a dispersed ray, as in medium_ior(); 0: all of them

// Inner side of a volume's surface: bends the ray, or mirrors it where no light leaves. The environment stands for
// light that the side reflects in part.
void leave_volume(GlobalsRef globals, MaterialRecord material, PathVertex vertex, vec3 base_color, float roughness,
                  inout uvec4 media, inout vec3 direction, inout vec3 throughput, inout vec3 sum, out bool passes) {
  const uint volume = vertex.point.material;
  const vec3 normal = vertex.point.normal_world;
  const uvec4 behind = media_behind(media, volume, true);
  const float ior = medium_ior(globals, behind.x, ray_channel) / medium_ior(globals, volume, ray_channel);
  const float reflectance = dielectric_reflectance(clamp(-dot(normal, direction), 0, 1), ior);
  const vec3 mirrored = reflect(direction, normal);
  const vec3 bent = refract(direction, normal, 1 / ior);
  passes = reflectance < 1 && dot(bent, bent) > 0;
  if (!passes) {
    direction = mirrored;
    return;
  }
  sum += throughput * reflectance * reflected_radiance(globals, mirrored, roughness);
  throughput *= (1 - reflectance) * base_color;
  direction = normalize(bent);
  media = behind;
}

// Derivatives of texture coordinates over a ray's width, in every direction of the triangle alike; the larger side of
// the ray's cut through its plane, as the raster chooses mip levels. width_m: across the ray.
void set_footprint(GlobalsRef globals, Hit hit, PrimitiveRecord primitive, MaterialRecord material, vec3 direction,
                   float width_m, inout SurfacePoint point) {
  if (!kTextures || (material.flags & FIRE3DV_MATERIAL_TEXTURED) == 0) return;
  vec3 corner[3];
  vec4 uv[3];
  for (int i = 0; i < 3; ++i) {
    const uint v = vertex_of(globals, primitive, hit.triangle, i);
    corner[i] = hit.world_from_object * vec4(PositionRef(globals.value.positions).at[v], 1);
    uv[i] = vec4(UvRef(globals.value.uvs).at[v], uv1_of(ExtrasRef(globals.value.extras), v));
  }
  const vec3 across = cross(corner[1] - corner[0], corner[2] - corner[0]);
  const float area = length(across);
  if (area <= 0) return;
  const vec4 a = uv[1] - uv[0], b = uv[2] - uv[0];
  const vec2 uv_areas = abs(vec2(a.x * b.y - a.y * b.x, a.z * b.w - a.w * b.z));
  const vec2 size = sqrt(uv_areas / area) * width_m / max(abs(dot(across, direction)) / area, 0.05);
  point.uv_dx = vec4(size.x, 0, size.y, 0);
  point.uv_dy = vec4(0, size.x, 0, size.y);
}

// eye_distance_m: of the origin. roughness: of the first surface, which blurs the environment and highlights.
// meets_all: blended and transmissive surfaces are hit, too. distance_m: of the first hit; kFar: none.
vec3 radiance_through(GlobalsRef globals, vec3 origin, vec3 direction, uvec4 media, float eye_distance_m,
                      float roughness, bool meets_all, out float distance_m) {
  vec3 sum = vec3(0), throughput = vec3(1);
  distance_m = kFar;
  float travelled_m = 0;
  for (uint i = 0; i < kMaxSurfaces; ++i) {
    const Hit hit = closest_hit(origin, direction, kFar, meets_all);
    if (!hit.found) break;
    const PrimitiveRecord primitive = primitive_of_hit(globals, hit.node, hit.geometry);
    MaterialRecord material = MaterialRef(globals.value.materials).at[primitive.material];
    // Highlights that are sharper than the lobe would be single bright pixels.
    material.roughness = max(material.roughness, roughness);
    const PathVertex vertex = path_vertex(globals, hit, primitive, material, direction);
    if (vertex.is_back && (material.flags & FIRE3DV_MATERIAL_DOUBLE_SIDED) == 0) material.emissive = vec3(0);
    SurfacePoint point = vertex.point;
    point.lift_m = vertex.rounding_m;
    const float length_m = distance(origin, point.position_world);
    travelled_m += length_m;
    const float width_m = push.pixel_angle_rad * (eye_distance_m + travelled_m) + roughness * roughness * travelled_m;
    set_footprint(globals, hit, primitive, material, direction, width_m, point);
    const vec4 base_color = surface_base_color(material, point);
    if (i == 0) distance_m = length_m;
    // Volumes of diffuse transmission alone are opaque in the raster.
    const bool bends = is_volume(material) && (material.flags & FIRE3DV_MATERIAL_TRANSMISSION) != 0;
    throughput *= transmittance(globals, medium_before(media, point.material, vertex, bends), length_m);
    bool passes = true;
    if (bends && vertex.is_back) {
      leave_volume(globals, material, vertex, base_color.rgb, roughness, media, direction, throughput, sum, passes);
    } else {
      vec3 behind;
      sum += throughput * shade(globals, material, base_color, point, -direction, behind).rgb;
      throughput *= behind;
      if (bends) {
        const float before = medium_ior(globals, media.x, ray_channel);
        media = media_behind(media, point.material, false);
        const vec3 bent = refract(direction, point.normal_world, before / medium_ior(globals, media.x, ray_channel));
        direction = dot(bent, bent) > 0 ? normalize(bent) : direction;
      }
    }
    if (largest(throughput) < 1e-3) return sum;
    const vec3 side = passes ? -point.plane_normal_world : point.plane_normal_world;
    origin = offset_from_surface(point.position_world, side, point.position_world, 0, vertex.rounding_m);
  }
  return sum + throughput * reflected_radiance(globals, direction, roughness);
}

#endif
