#version 450 core
// One corner of one piece of one agent: the piece's nearest view from where the eye is in its joint's space, on the plane
// fitted to the piece, moved as the joint is.
#include "renderers/shaders/frame.glsl"
#include "renderers/shaders/palette.glsl"
#include "renderers/perjoint/perjoint_table.glsl"
#include "renderers/impostor/views/view_grid.glsl"

layout(binding = CB_TEXTURE_TILES) uniform samplerBuffer tile_texels;        // two a tile: PerJointBake::tiles
layout(binding = CB_TEXTURE_OUTLINES) uniform samplerBuffer outline_texels;  // one a corner
layout(binding = CB_TEXTURE_VIEWS) uniform samplerBuffer view_texels;        // right and up of every view
layout(binding = CB_PERJOINT_TEXTURE_PIECES) uniform samplerBuffer piece_texels;
layout(location = CB_LOCATION_FIRST) uniform uint first;  // position in LIST of the first instance
layout(location = CB_LOCATION_SLOT) uniform uint slot;    // its place among the palettes

layout(location = 0) out vec3 v_texel;
layout(location = 1) flat out vec4 v_light;  // the light's direction on the view's axes, unit; w: the outfit
#ifdef CB_IDS
layout(location = 2) flat out uint v_id;
#endif
#ifdef CB_STORED_DEPTH
layout(location = 3) out float v_depth;             // of the capture plane along the view, metres
layout(location = 4) flat out float v_depth_range;  // that the end of the stored depths adds
layout(location = 5) flat out float v_texel_height; // metres of a texel over the stored depths' end
#endif

void main() {
  int piece = gl_VertexID / CB_PERJOINT_CORNERS;
  int corner = gl_VertexID - piece * CB_PERJOINT_CORNERS;
  uint instance = uint(gl_InstanceID);
  uint agent = list[first + instance];
  int at = piece * CB_PERJOINT_PIECE_TEXELS;
  vec4 rest0 = texelFetch(piece_texels, at);
  vec4 rest1 = texelFetch(piece_texels, at + 1);
  vec4 rest2 = texelFetch(piece_texels, at + 2);
  vec4 centre = texelFetch(piece_texels, at + 3);
  uint joint = uint(texelFetch(piece_texels, at + 4).x);
  uint row = ((slot + instance) * table.first.z + joint) * 3u;
  vec4 row0 = palette_row(row);
  vec4 row1 = palette_row(row + 1u);
  vec4 row2 = palette_row(row + 2u);
  // World from the rest pose's model space: columns.
  mat3 to_joint = transpose(mat3(rest0.xyz, rest1.xyz, rest2.xyz));
  mat3 joint_to_world = transpose(mat3(row0.xyz, row1.xyz, row2.xyz));
  mat3 to_world = joint_to_world * to_joint;
  vec3 middle = joint_to_world * (to_joint * centre.xyz + vec3(rest0.w, rest1.w, rest2.w)) + vec3(row0.w, row1.w, row2.w);
  float determinant = determinant(to_world);
  float size = max(length(to_world[0]), max(length(to_world[1]), length(to_world[2])));
  bool hidden = !(abs(determinant) > 1e-9 * size * size * size);  // game kits scale to nothing what is not shown
  mat3 to_rest = hidden ? mat3(1.0) : inverse(to_world);

  int flipped;
  vec3 eye = to_rest * -middle;
  int view = pick_view(eye, table.grid, table.span, flipped);
  vec3 right = texelFetch(view_texels, 2 * view).xyz;
  vec3 up = texelFetch(view_texels, 2 * view + 1).xyz;
  vec3 to_eye = cross(right, up);
  int tile = int(table.first.x) + piece * int(table.first.y) + view;
  vec4 place = texelFetch(tile_texels, 2 * tile);
  vec4 plane = texelFetch(tile_texels, 2 * tile + 1);
  vec2 p = texelFetch(outline_texels, tile * CB_PERJOINT_CORNERS + corner).xy;
  vec2 metres = p * table.scale.x;
  vec3 on_capture = right * metres.x + up * metres.y;
  float height = plane.x * metres.x + plane.y * metres.y + plane.z;
  vec3 world = middle + to_world * (on_capture + to_eye * height);
  gl_Position = frame.clip_from_world * vec4(world, 1.0);
  if (hidden) gl_Position = vec4(0.0, 0.0, 2.0, 1.0);  // beyond the near plane
  v_texel = vec3((p + place.xy) * table.scale.yz, place.z);

  vec3 light = to_rest * frame.light_direction.xyz;
  light *= inversesqrt(max(dot(light, light), 1e-30));
  uvec3 identity = agent_identity(agent);
  v_light = vec4(dot(light, right), dot(light, up), dot(light, to_eye), float(identity.x));
#ifdef CB_IDS
  v_id = identity.y;
#endif
#ifdef CB_STORED_DEPTH
  vec3 backward = transpose(frame.view_from_world)[2].xyz;
  v_depth = -dot(backward, middle + to_world * on_capture);
  v_depth_range = -dot(backward, to_world * to_eye) * centre.w;
  v_texel_height = table.scale.x / centre.w;
#endif
}
