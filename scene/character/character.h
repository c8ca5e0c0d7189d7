// Character: an immutable rigged, animated mesh as every representation receives it.
//
// Spaces. "glTF space" is the file's own default scene after all node transforms, +Y up (turned where `turn_deg` or
// `up` ask for it). "Model space" is what the crowd uses: metres, the character facing +Z, the height at which its
// soles stay in the upright clip (see Placement and pose/stand.h) at y = 0, the pivot at x = z = 0: the mean ground
// projection over that clip of the skin's root, or of the body's centre of mass where the root lies elsewhere.
// `Placement::model_from_gltf` maps one to the other; with height "as_is" it is the identity.
#pragma once
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/image.h"

namespace crowdbench::scene {

inline constexpr int kInfluences = 4;  // joints of a vertex: the largest, renormalised

// One node of the hierarchy. Parents come before children. A node has either a matrix or translation/rotation/scale;
// only the latter can be animated.
struct Node {
  std::string name;
  int parent = -1;  // index into Skeleton::nodes, -1 for a root
  bool has_matrix = false;
  glm::dmat4 matrix{1.0};
  glm::dvec3 translation{0.0};
  glm::dquat rotation{1.0, 0.0, 0.0, 0.0};
  glm::dvec3 scale{1.0};
};

// One entry of the matrix palette that vertices index: posed matrix = world(node) * inverse_bind. A rigid mesh parented
// to a node has an entry of its own with an identity inverse bind matrix. Entries of several skins follow each other.
struct Joint {
  std::string name;  // the node's
  int node = 0;
  glm::dmat4 inverse_bind{1.0};
  bool rigid = false;  // true for the entry of an unskinned mesh
};

// What the file says that a node is in a human body (VRM: "hips", "leftUpperArm").
struct HumanBone {
  std::string name;
  int node = 0;
};

struct Skeleton {
  std::vector<Node> nodes;
  std::vector<Joint> joints;
  int root_node =
      -1;  // the first skin's root (its `skeleton`, else the joints' lowest common ancestor); -1 without skin
  std::vector<HumanBone> human_bones;  // empty: the file does not say
};

enum class Interpolation : uint8_t { step, linear, cubic_spline };
enum class Target : uint8_t { translation, rotation, scale };

// values: 3 (or 4, x y z w, for rotations) a key; for cubic_spline in-tangent, value, out-tangent a key.
struct Channel {
  int node = 0;
  Target target = Target::translation;
  Interpolation interpolation = Interpolation::linear;
  std::vector<double> times;   // seconds, strictly increasing, the file's own axis
  std::vector<double> values;  // times.size() * (1 or 3) * (3 or 4)
};

struct Clip {
  std::string name;  // as in the file; may be empty
  double start = 0;  // first key of any channel, seconds
  double end = 0;    // last key
  std::vector<Channel> channels;
  bool loops = true;      // built-in clips that must not wrap set false
  bool together = false;  // not in the file: clips that move different things, played at once
  bool borrowed = false;  // of another file
  // Of borrowed clips that stay in place: where the feet of the figure that it was made for say that it goes; units of
  // this file a second, (x, z) of its axes. Feet of another shape say it less well.
  std::optional<glm::dvec2> ground_velocity;
  double duration() const { return end - start; }
};

enum class UpAxis : uint8_t { y, z };

// Linear-light or sRGB as stated; index -1 = none.
struct Material {
  std::string name;
  glm::vec4 base_colour{1.0F};  // linear factor
  int base_colour_image = -1;   // into Character::images
  glm::vec3 emissive{0.0F};     // linear factor, strength included
  int emissive_image = -1;
  bool unlit = false;  // KHR_materials_unlit
  bool double_sided = false;
  // A surface is there where its alpha (factor x image x vertex colour) is at least this; 0: everywhere.
  float alpha_cutoff = 0;
  uint8_t slot = 0;  // the outfit's slot that colours it, 0..255: the material's index, 255 at most
};

// How a texture is sampled where it is smaller than its texels; within a mip level, then between levels. `nearest` and
// `linear` use the first level alone.
enum class MinFilter : uint8_t {
  linear_mipmap_linear,
  linear_mipmap_nearest,
  nearest_mipmap_linear,
  nearest_mipmap_nearest,
  linear,
  nearest
};

struct Texture {
  Image8 image;  // RGBA, sRGB-encoded
  bool repeat_u = true, repeat_v = true;
  bool mirrored_u = false, mirrored_v = false;             // only with repeat
  bool nearest = false;                                    // magnified: nearest texel, else bilinear
  MinFilter min_filter = MinFilter::linear_mipmap_linear;  // minified
};

// A run of triangles with one material, under one node.
struct Primitive {
  uint32_t first_index = 0;
  uint32_t index_count = 0;  // multiple of 3
  uint32_t first_vertex = 0;
  uint32_t vertex_count = 0;
  int material = 0;       // into Character::materials; a default material exists when the file has none
  int node = 0;           // the mesh's node, in `Skeleton::nodes`
  int gltf_node = 0;      // the node's index in the file
  bool flat = false;      // the file has no normals: shaded by its faces as posed. Mesh::normals has the bind pose's
  bool mirrored = false;  // the node's rest transform has a negative determinant: clockwise is the front
};

// Structure of arrays; all of equal length (emissive_uvs and colours may be empty). Positions and normals are the
// mesh's own (bind space). They hold what is drawn and nothing else. Vertex order: nodes by ascending file index, then
// primitives, then vertices, as `crowdbench pose` reports.
struct Mesh {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;  // unit; computed flat when the file has none
  std::vector<glm::vec2> uvs;      // base colour, KHR_texture_transform applied; (0,0) = first texel's corner, v down
  std::vector<glm::vec2> emissive_uvs;  // empty: the same as uvs
  std::vector<glm::vec4> colours;       // COLOR_0, linear; empty: white
  std::vector<glm::u16vec4> joints;     // into Skeleton::joints
  std::vector<glm::vec4> weights;       // sum 1 within 1e-6
  std::vector<uint32_t> indices;        // triangles, counter-clockwise is the front
  std::vector<Primitive> primitives;
  // Where the file's own vertices lie, in the order stated above; empty: vertex i is the file's vertex i. A primitive
  // without normals is drawn flat, so a vertex shared by faces that point apart is doubled at the end of its
  // primitive's range. Vertices that nothing drawn names are only there with LoadOptions::undrawn.
  std::vector<uint32_t> file_vertices;
  size_t file_vertex_count() const { return file_vertices.empty() ? positions.size() : file_vertices.size(); }
};

// The default clip, the normalisation and what moves it: computed at load, shown by `inspect`.
struct Placement {
  glm::dmat4 model_from_gltf{1.0};  // uniform scale and translation
  double scale = 1.0;               // metres a glTF unit
  double height = 0;                // metres: height of the upright clip's first pose, after scaling
  int default_clip = -1;            // -1: no clip of non-zero length
  // Whose first pose gives the height, the ground and the pivot: of the clips in use (NormaliseOptions::clips, else the
  // default clip) the one whose first pose is tallest; the default clip where that one lies, sits or crouches beside
  // it.
  int upright_clip = -1;  // -1: the bind pose
};

struct ClipMotion {
  // How the body (the mass of what is drawn, whatever node moves it) has moved from the first key to the last, model
  // space; stripped from the pose evenly with time. Turned by root_yaw about the vertical axis through root_axis, where
  // it turns, else moved by root_displacement; metres; y only where it climbs or descends by more than sway.
  glm::dvec3 root_displacement{0.0};
  double root_yaw = 0;             // radians, from +Z towards +X
  glm::dvec3 root_axis{0.0};       // with root_yaw: where that axis stands
  double ground_speed = 0;         // metres a second over the ground at the cycle's start; 0 for clips that stand
  glm::dvec2 direction{0.0, 1.0};  // unit, (x, z): where to, as the character faces +Z
  double yaw_rate = 0;             // radians a second by which the way over the ground turns
  bool from_stance = false;        // the speed is that of the foot on the ground, because the body stays in place
  double closing_seconds = 0;      // appended to a loop whose last key does not repeat the first: its last key interval
};

struct Character {
  std::string name;          // file stem or "mannequin"
  std::string source;        // path as given, or "mannequin:..."
  std::string content_hash;  // SHA-256 of everything that a bake depends on
  Skeleton skeleton;
  Mesh mesh;
  // Coarser meshes of the same character that the file holds, the first of them LOD1: with the same skeleton, materials
  // and placement, which are made of `mesh`, LOD0, alone. Empty: the file has none.
  std::vector<Mesh> levels;
  std::vector<Material> materials;
  std::vector<Texture> images;
  std::vector<Clip> clips;
  std::vector<ClipMotion> motion;  // one for each clip
  Placement placement;
  std::vector<std::string> warnings;
  int file_max_influences = 0;  // before the reduction to four
  // What the shown nodes of the file hold, seen or not; vertices that primitives share count once. 0: not from a file.
  size_t file_vertices = 0;
  size_t file_triangles = 0;
  size_t triangles() const { return mesh.indices.size() / 3; }
};

// The clip of that name, else of that index, else std::nullopt. A name wins over an index.
std::optional<int> find_clip(const Character& character, std::string_view name_or_index);
// "cannot find clip X in F; it has A, B, C" as an Error when absent.
int require_clip(const Character& character, std::string_view name_or_index);

}  // namespace crowdbench::scene
