// Angles about x, y and z in degrees, of a pose's three rows: turns about x, then y, then z of the world.
export function degrees(rows) {
  const [x, y, z, w] = quaternion(rows);
  const angles = [Math.atan2(2 * (y * z + w * x), w * w - x * x - y * y + z * z), Math.asin(Math.min(Math.max(-2 * (x * z - w * y), -1), 1)),
                  Math.atan2(2 * (x * y + w * z), w * w + x * x - y * y - z * z)];
  return angles.map((angle) => angle * 180 / Math.PI);
}

// Quaternion x, y, z, w of a pose's three rows. Scales are left out.
export function quaternion(rows) {
  const columns = [0, 1, 2].map((column) => rows.map((row) => row[column]));
  const [a, b] = columns.map((column) => column.map((value) => value / (Math.hypot(...column) || 1)));
  // A mirrored pose has no rotation of its own: the third axis is that of the first two.
  const c = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  // The largest part comes from a root, the others from differences and sums: their signs are sure.
  const squares = [1 + a[0] - b[1] - c[2], 1 - a[0] + b[1] - c[2], 1 - a[0] - b[1] + c[2], 1 + a[0] + b[1] + c[2]];
  const largest = squares.indexOf(Math.max(...squares));
  const [xy, xz, yz] = [a[1] + b[0], a[2] + c[0], b[2] + c[1]];
  const [xw, yw, zw] = [b[2] - c[1], c[0] - a[2], a[1] - b[0]];
  const s = squares[largest];
  const parts = [[s, xy, xz, xw], [xy, s, yz, yw], [xz, yz, s, zw], [xw, yw, zw, s]][largest];
  return parts.map((part) => part / (2 * Math.sqrt(s)));
}
