#!/usr/bin/env bash
# Check for test prerequisites: lavapipe with ray queries, the validation layer and golden images. A missing one fails
# the run, since tests must not pass by skipping.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

missing=0
lack() { printf 'missing: %s\n' "$*" >&2; missing=1; }

drivers=(/usr/share/vulkan/icd.d/lvp_icd*.json)
if [ ! -e "${drivers[0]}" ]; then
  lack "lavapipe, the software Vulkan driver: run tools/setup.sh"
else
  driver_list=$(IFS=:; echo "${drivers[*]}")
  export VK_DRIVER_FILES=$driver_list VK_ICD_FILENAMES=$driver_list
  seen=$(env -u DISPLAY -u WAYLAND_DISPLAY vulkaninfo 2>/dev/null || true)
  grep -q 'deviceName *= *llvmpipe' <<<"$seen" || lack "lavapipe: ${drivers[0]} is there, but gives no device"
  grep -q 'VK_KHR_ray_query' <<<"$seen" || lack "ray queries in lavapipe: Mesa 24.1 or newer is needed, run tools/setup.sh"
  grep -q 'VK_LAYER_KHRONOS_validation' <<<"$seen" || lack "the Khronos validation layer: run tools/setup.sh"
fi
goldens=(tests/render/goldens/*.png)
[ -e "${goldens[0]}" ] || lack "golden images in tests/render/goldens"

[ $missing = 0 ] || exit 1
printf 'lavapipe with ray queries, the validation layer and %d golden images are here\n' "${#goldens[@]}"
