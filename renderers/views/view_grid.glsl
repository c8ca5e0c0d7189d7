// The nearest view of a grid, by the same formulas as view_grid.cpp. d: from the capture centre to the eye in model
// space, any length.
// grid: x = kind (0 sphere, 1 cube, 2 hemi), y = azimuths or n, z = elevations, w = 1 when mirrored.
// span: x = azimuth step, y = lowest elevation, z = elevation step (radians), w = tan(lowest elevation).
// Returns the view; `flipped` is 1 when its mirror image is meant.
int pick_view(vec3 d, ivec4 grid, vec4 span, out int flipped) {
  flipped = 0;
  if (grid.x == 0) {
    if (grid.w != 0 && d.x < 0.0) {
      flipped = 1;
      d.x = -d.x;
    }
    float nearest = floor(atan(d.x, d.z) / span.x + 0.5);
    float at = nearest * span.x;
    float along = d.x * sin(at) + d.z * cos(at);
    int row = clamp(int(floor((atan(d.y, along) - span.y) / span.z + 0.5)), 0, grid.z - 1);
    // In [-y / 2, y / 2]; the remainder of a negative number is undefined in GLSL.
    int column = int(nearest);
    if (column < 0) column += grid.y;
    column = grid.w != 0 ? clamp(column, 0, grid.y - 1) : column == grid.y ? 0 : column;
    return row * grid.y + column;
  }
  d.y = max(d.y, length(d.xz) * span.w);
  vec3 a = abs(d);
  int n = grid.y;
  if (grid.x == 1) {
    float largest = max(max(a.x, a.y), max(a.z, 1e-30));
    int face;
    vec2 uv;
    if (a.y >= a.x && a.y >= a.z) {
      face = d.y < 0.0 ? 3 : 2;
      uv = d.xz;
    } else if (a.x >= a.z) {
      face = d.x < 0.0 ? 1 : 0;
      uv = d.zy;
    } else {
      face = d.z < 0.0 ? 5 : 4;
      uv = d.xy;
    }
    ivec2 cell = clamp(ivec2(floor((uv / largest * 0.5 + 0.5) * float(n))), ivec2(0), ivec2(n - 1));
    return (face * n + cell.y) * n + cell.x;
  }
  vec2 uv = vec2(d.x + d.z, d.x - d.z) / max(a.x + a.y + a.z, 1e-30);
  ivec2 cell = clamp(ivec2(floor((uv * 0.5 + 0.5) * float(n - 1) + 0.5)), ivec2(0), ivec2(n - 1));
  return cell.y * n + cell.x;
}
