// The cube's face that a direction goes through (0 +x, 1 -x, 2 +y, 3 -y, 4 +z, 5 -z), and where: 0..1 across it.
int cube_face(vec3 d, out vec2 at) {
  vec3 a = abs(d);
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
  at = uv / max(max(a.x, a.y), max(a.z, 1e-30)) * 0.5 + 0.5;
  return face;
}

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
    vec2 at;
    int face = cube_face(d, at);
    ivec2 cell = clamp(ivec2(floor(at * float(n))), ivec2(0), ivec2(n - 1));
    return (face * n + cell.y) * n + cell.x;
  }
  vec2 uv = vec2(d.x + d.z, d.x - d.z) / max(a.x + a.y + a.z, 1e-30);
  ivec2 cell = clamp(ivec2(floor((uv * 0.5 + 0.5) * float(n - 1) + 0.5)), ivec2(0), ivec2(n - 1));
  return cell.y * n + cell.x;
}

vec3 cube_direction(int face, vec2 uv) {
  float side = (face & 1) == 0 ? 1.0 : -1.0;
  return face < 2 ? vec3(side, uv.y, uv.x) : face < 4 ? vec3(uv.x, side, uv.y) : vec3(uv, side);
}

// The three views around a direction, by the same formulas as ViewGrid::blend: corners of a cell of the grid.
void blend_views(vec3 d, ivec4 grid, vec4 span, out ivec3 views, out vec3 weights, out int flipped) {
  flipped = 0;
  vec2 at;
  int face = 0;
  if (grid.x == 0) {
    if (grid.w != 0 && d.x < 0.0) {
      flipped = 1;
      d.x = -d.x;
    }
    float azimuth = atan(d.x, d.z);
    at = vec2((azimuth < 0.0 ? azimuth + 6.28318530718 : azimuth) / span.x,
              (atan(d.y, length(d.xz)) - span.y) / span.z);
    at = clamp(at, vec2(0.0), vec2(grid.y - grid.w, grid.z - 1));
  } else {
    d.y = max(d.y, length(d.xz) * span.w);
    vec3 a = abs(d);
    if (grid.x == 1) {
      face = cube_face(d, at);
      at = at * float(grid.y) - 0.5;
    } else {
      vec2 uv = vec2(d.x + d.z, d.x - d.z) / max(a.x + a.y + a.z, 1e-30);
      at = clamp((uv * 0.5 + 0.5) * float(grid.y - 1), vec2(0.0), vec2(grid.y - 1));
    }
  }
  vec2 low = floor(at);
  vec2 f = at - low;
  bool lower = f.x + f.y < 1.0;
  weights = lower ? vec3(1.0 - f.x - f.y, f.x, f.y) : vec3(f.x + f.y - 1.0, 1.0 - f.x, 1.0 - f.y);
  ivec2 cell = ivec2(low);
  for (int i = 0; i < 3; ++i) {
    ivec2 c = cell + (lower ? ivec2(i == 1 ? 1 : 0, i == 2 ? 1 : 0) : ivec2(i == 1 ? 0 : 1, i == 2 ? 0 : 1));
    if (grid.x == 0)
      views[i] = min(c.y, grid.z - 1) * grid.y + (grid.w != 0 ? min(c.x, grid.y - 1) : c.x % grid.y);
    else if (grid.x == 1)
      // Past a face's edge the nearest view on the next face, below the lowest elevation that of the raised direction.
      views[i] = pick_view(cube_direction(face, (2.0 * vec2(c) + 1.0) / float(grid.y) - 1.0), grid, span, flipped);
    else
      views[i] = min(c.y, grid.y - 1) * grid.y + min(c.x, grid.y - 1);
  }
}
