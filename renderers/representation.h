// Representation: how a crowd is drawn. The one interface of this project with virtual functions.
//
// To add one: a folder here with a README, the header, the bake, the draw and the shaders, that defines one
// RepresentationType; and one line in registry.cpp. The driver, the sweeps, the metrics, the studies and the reports
// walk the registry and ask the type what it can do; none of them spells a name (tests/renderers/names_test.cpp).
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scene/character/character.h"
#include "scene/crowd/crowd.h"
#include "scene/frame/frame.h"
#include "scene/pose/lod_mesh.h"
#include "scene/pose/pose_bank.h"

namespace crowdbench::gl {
class Context;
}

namespace crowdbench::renderers {

class FrameResources;  // renderers/frame/frame_resources.h: the frame's uniforms, agents, outfits and posed palettes on
                       // the GPU

// "name:key=value,key=value" or "hybrid(NEAR,FAR,key=value,...)" taken apart. Values are kept as text until the type
// reads them.
struct Spec {
  std::string name;
  std::vector<std::pair<std::string, std::string>> options;  // in the order given; keys are unique
  std::vector<Spec> components;                              // hybrid: near, far
  // The canonical text: options in the order of the type's table, defaults left out; parses to the same Spec but for
  // the order of options and defaults.
  std::string text() const;
};
// "reference" stands for the name of the reference. Throws Error: unknown name or option (naming the nearest), a value
// twice, bad brackets.
Spec parse_spec(const std::string& text);
// The grammar, against a table of types given by the caller:
//   spec  = name [":" option {"," option}]  |  name "(" component {"," component} {"," option} ")"
//   component = spec | "(" spec ")"        option = key "=" value
// Within a name's brackets an option that follows a component with ":" belongs to that component when its type knows
// the key; a component in brackets of its own takes none from outside. A value holds no comma, colon or bracket.
struct RepresentationType;
Spec parse_spec(const std::string& text, const std::vector<RepresentationType>& types);
std::string canonical_text(const Spec& spec, const std::vector<RepresentationType>& types);

// "mesh,flat:views=64,frames=8,hybrid(mesh,flat,distance=10)" to three representations: a comma separates where the
// next piece does not read key=value, and never within brackets. Throws Error.
std::vector<Spec> parse_specs(const std::string& text);

// The spec with floor=1, whatever was given.
Spec with_floor(Spec spec);
bool is_floor(const Spec& spec);

// Sets the option `debug` of a representation (of both components of a hybrid, where they know the view) to one of its
// debug views, whatever was given. Throws Error naming the views that there are.
void set_debug_view(Spec& spec, const std::string& view);

// One option of a representation: what `info --representations` prints and parse_spec checks.
struct OptionDoc {
  std::string key;
  std::string values;  // "linear|adaptive|cone", "16+7", "8..4096"
  std::string default_value;
  std::string meaning;
  // Of values that are neither words nor a range: throws Error naming `where` for what cannot be one.
  void (*check)(const std::string& value, const std::string& where) = nullptr;
};

// Bytes, exactly; texture bytes count every mip level.
struct Footprint {
  uint64_t texture_bytes = 0;
  uint64_t buffer_bytes = 0;  // vertices, indices, tables; pose palettes are the shared bank's, counted apart
  uint64_t upload_bytes_per_frame = 0;
  uint64_t disk_bytes = 0;  // of the cache entry, 0 when not cached
  uint64_t gpu_bytes() const { return texture_bytes + buffer_bytes; }
};

// One of the items that a bake consists of, a joint's box for example.
struct BakeItem {
  std::string name;
  std::vector<std::pair<std::string, double>> facts;  // ("texels", 256), ...; the same ones for every item
};

// What a bake kept of all that its options ask for, because MakeContext::required_by shows no more.
struct Kept {
  std::string unit;  // what is counted: "tiles"
  uint64_t kept = 0;
  uint64_t whole = 0;
  uint64_t kept_bytes = 0;   // of what can be left out, on the GPU
  uint64_t whole_bytes = 0;  // the same had nothing been left out
};

// A level of detail of a character's mesh, and how far its surface is from the whole mesh's: symmetric distances, over
// poses of the clips in use (scene::lod_error).
struct LevelInfo {
  std::string character;
  uint64_t triangles = 0;
  uint64_t of_triangles = 0;  // the whole mesh's
  double height = 0;          // metres, of the character at scale 1
  scene::LodError error;      // metres
  std::string worst_clip;     // of the pose with the largest error
  // What meshoptimizer's simplifier makes of the whole mesh in one pose, asked for as many triangles; absent where the
  // level is the file's own.
  struct Other {
    uint64_t triangles = 0;
    double stated = 0;  // metres, as it states it
    scene::LodError error;
  };
  std::optional<Other> meshoptimizer;
  std::string note;  // what was asked for and could not be had; empty: nothing
  // The largest error where the figure is so many pixels tall; 0 where it has no height.
  double pixels(double figure_px) const { return height > 0 ? error.max / height * figure_px : 0; }
};
struct LevelMesh {
  scene::Mesh mesh;
  LevelInfo info;
};

struct BakeInfo {
  double seconds = 0;       // spent now, on baking or on reading the cache
  double made_seconds = 0;  // what making the bakes took, now or when they were stored; 0 where nothing is stored
  bool cached = false;      // came from the cache
  std::string
      cache_key;  // SHA-256 over character, options, bake version, GL renderer and version; empty: nothing baked
  // What the bake holds, for people and JSON: ("views", 136), ("tiles", 1360), ("texel_mm", 14.5), ...
  std::vector<std::pair<std::string, double>> facts;
  std::vector<BakeItem> items;  // of the only character; none where there are several
  std::vector<Kept> kept;       // one a representation that something was left out of; a hybrid's are its components'
  std::vector<std::string> notes;  // what was asked for and could not be had, and why
  std::vector<LevelInfo> levels;   // that it draws, one a character and level; a hybrid's are its components'
};

// Seconds that it takes with nothing in the cache, the uploads left out where bakes are kept.
inline double cold_seconds(const BakeInfo& bake) { return bake.cache_key.empty() ? bake.seconds : bake.made_seconds; }

// agents[c]: indices into frame.agents[c], ascending.
using AgentLists = std::vector<std::vector<uint32_t>>;

// Every agent of a frame.
AgentLists all_agents(const scene::Frame& frame);

// Who draws an agent: the share of its pixels that each of Representation::components() has. They sum to 1; more than
// one is above 0 while the agent fades from one to another.
struct AgentShares {
  uint32_t id = 0;  // FrameAgent::id
  std::vector<float> shares;
  bool operator==(const AgentShares&) const = default;
};

// Which outputs the bound target has. Timed frames draw without ids; a test shows that their colours are equal.
struct Pass {
  bool ids = false;     // second colour attachment, R32UI: agent index + 1
  bool linear = false;  // colour attachment 0 is linear float, else sRGB-encoded 8-bit
  // Depth is written wherever a fragment arrives, also where it is discarded later (shaders define CB_TOUCHED): the
  // pixels that a draw touches. Its colours, ids and depths are of no other use.
  bool touched = false;
  // Instead of a picture, R and G of the colours are the place, in texels of level 0, at which the fragment reads its
  // map, and B is the level read: for measuring how many pixels a texel covers. With `linear`, and only from a
  // representation that shows_texels().
  bool texels = false;
  // Only pixels whose threshold lies in the range last given to FrameResources::set_dither are drawn (shaders define
  // CB_DITHER): the two sides of a cross-fade.
  bool dithered = false;
  // Samples a pixel of the bound target (multisampling); above 1 only without ids, touched and texels. Edges of
  // triangles are covered by sample as the hardware does. What discards fragments draws by sample (gl/per_sample.h), so
  // that its outlines are as smooth; a cut-out material of a mesh turns its alpha into coverage.
  int samples = 1;
  auto operator<=>(const Pass&) const = default;
};

class Representation {
 public:
  virtual ~Representation() = default;
  // Draws the listed agents into the bound target with depth test GREATER and depth writes on. Leaves the GL state as
  // it found it (a program, a vertex array and textures may stay bound). Never reads a clock.
  //
  // The size of the picture is frame.width x frame.height, on the GPU frame.viewport, and never the target's: a
  // supersampled capture draws k x k samples for each pixel of it. Whatever a representation chooses by pixels (the
  // level of its maps, the tier of its boxes, the switch of a hybrid) it chooses by the picture's, so that
  // supersampling smooths what is drawn and draws nothing else. (What the hardware filters by itself, as the textures
  // of the mesh, goes by samples.)
  virtual void draw(const scene::Frame& frame, const FrameResources& resources, const AgentLists& agents,
                    const Pass& pass) = 0;
  virtual Footprint footprint() const = 0;
  virtual BakeInfo bake_info() const { return {}; }
  // Triangles submitted for one agent of character c, of the finest where agents change between levels (a pair for
  // `ratio` and the report).
  virtual uint64_t triangles(size_t character) const = 0;
  // Metres that one texel of character c covers at scale 1, for switching by pixels a texel; 0: it has no such texels.
  virtual double texel_metres(size_t /*character*/) const { return 0; }
  // Whether it draws Pass::texels.
  virtual bool shows_texels() const { return false; }
  // The phase of the stored frame that stands for a phase in [0, 1) of a clip of the bank; the phase itself where every
  // phase is drawn.
  virtual double shown_phase(size_t /*character*/, int /*bank_clip*/, double phase) const { return phase; }
  // Representations whose picture of a tick depends on the ticks before it: `advance` shows them a frame that is not
  // drawn, so that a later tick can be drawn as a sequence from the first would show it. Everybody else is a function
  // of the frame.
  virtual bool has_history() const { return false; }
  virtual void advance(const scene::Frame& /*frame*/, const AgentLists& /*agents*/) {}

  // Representations whose agents switch between others: which those are, nearest first, those of a component that has
  // such itself in its place. None: no agent ever switches.
  virtual std::vector<std::string> components() const { return {}; }
  // Who draws the listed agents in this frame, in the order of the lists, one character after the other; empty where
  // there are no components. To the history it is a draw of the frame: of the frame that was drawn last it changes
  // nothing.
  virtual std::vector<AgentShares> shares(const scene::Frame& /*frame*/, const AgentLists& /*agents*/) { return {}; }
  // Until it is called with none, `draw` draws these agents by these shares, whoever would draw them otherwise: a frame
  // without its switches. Such draws leave the history as it is.
  virtual void hold(const std::vector<AgentShares>& /*held*/) {}
};

// How one agent is seen at one tick: the eye in the agent's model space (metres at scale 1, from its pivot), and its
// pose.
struct ViewSample {
  glm::vec3 eye{0.0F};
  int bank_clip = 0;
  float phase = 0;
};
// Shows every view_sample of one character that a scenario will give.
using VisitViewSamples = std::function<void(size_t character, const std::function<void(const ViewSample&)>& see)>;

// How bakes are made and kept.
struct BakePolicy {
  uint64_t budget = uint64_t{512} << 20;
  bool use_cache = true;
  bool rebake = false;
  bool progress = true;
};

struct MakeContext {
  gl::Context& context;
  const scene::Cast& cast;
  uint64_t bake_budget = uint64_t{512} << 20;  // bytes; a bake that needs more throws Error naming what to lower
  bool use_cache = true;
  bool rebake = false;  // bake anew although the cache has it, and replace that
  bool progress = true;
  // Set: types that honour it (honours_required_by) keep only what these view samples show, and show nothing elsewhere.
  VisitViewSamples required_by = {};

  BakePolicy policy() const { return {bake_budget, use_cache, rebake, progress}; }
};

struct ViewSampling;  // renderers/impostor/views/view_sampling.h

// What it is suited for beyond what is measured, a clause each, argued from how it works: "yes", or what stands against
// it.
struct Suitability {
  std::string new_clips;   // clips that come at run time
  std::string close_by;    // figures of several hundred pixels
  std::string from_above;  // steep views
  std::string shadows;     // of one limb on another, and of figures on each other
};

struct RepresentationType {
  std::string name;
  std::string summary;  // one line
  std::vector<OptionDoc>
      options;  // "floor" is common to all: 1 draws the representation's floor (spec'd in its README)
  std::function<std::unique_ptr<Representation>(const MakeContext&, const Spec&)> make;
  size_t components = 0;  // how many representations it is made of, given in brackets: 2 for hybrid(near,far)

  // What it can do: asked by everybody who would otherwise have to know its name.
  bool reference = false;    // all others are held against it; true of exactly one type
  bool required_by = false;  // keeps only what MakeContext::required_by shows
  // How coarsely a spec of this type samples views and poses of a character in the poses of a bank, without baking it.
  // Null where no views are stored.
  ViewSampling (*view_sampling)(const Spec& spec, const scene::Character& character,
                                const std::shared_ptr<const scene::PoseBank>& bank) = nullptr;
  // The level of detail of a character's mesh that a spec of this type draws, made or read from the cache, without a
  // driver; std::nullopt: the whole mesh. Null where no levels are drawn by themselves.
  std::optional<LevelMesh> (*level)(const Spec& spec, const std::shared_ptr<const scene::Character>& character,
                                    const std::shared_ptr<const scene::PoseBank>& bank,
                                    const BakePolicy& policy) = nullptr;

  // What floor=1 still does, for reports, to follow "its floor is": "the mesh in one pose, without skinning".
  std::string floor;
  Suitability suits;
  std::string example_options;  // of example_spec: "distance=9"; empty: none
};

const std::vector<RepresentationType>& representation_types();           // registry.cpp
const RepresentationType& representation_type(const std::string& name);  // throws Error naming the nearest
const RepresentationType& reference_type();
Spec reference_spec();  // without options
// What commands hold against the reference where nothing is asked for: the first type that stores views.
Spec default_impostor();
// Whether the name alone is a spec: what lists of all representations offer.
bool stands_alone(const RepresentationType& type);
// A spec of the type, for help and tests: of the reference and the default impostor where it is made of two.
std::string example_spec(const RepresentationType& type);
// Whether the spec, or one of its components, keeps only what MakeContext::required_by shows.
bool honours_required_by(const Spec& spec);
// The words of the option `debug` but for "none"; empty where there is no such option.
std::vector<std::string> debug_views(const RepresentationType& type);
// Those of all types, for help: "NAME has VIEW, VIEW; NAME has VIEW".
std::string debug_views_of_all();
// RepresentationType::floor by name, of all types.
std::map<std::string, std::string> floors_by_name();
// Throws Error where the table of options rules out a value of one of them, as parse_spec() does.
void require_option_value(const RepresentationType& type, const std::string& key, const std::string& value);
// The type's options with "floor", which all have, at the end.
std::vector<OptionDoc> option_docs(const RepresentationType& type);
std::unique_ptr<Representation> make_representation(const MakeContext& context, const Spec& spec);

// Reads options for a type's make(): defaults from its table, every fault an Error naming the representation and the
// option.
class OptionReader {
 public:
  OptionReader(const RepresentationType& type, const Spec& spec);
  std::string text(const std::string& key) const;
  // One of the words; returns its position.
  size_t choice(const std::string& key, const std::vector<std::string>& words) const;
  int64_t integer(const std::string& key, int64_t low, int64_t high) const;
  double number(const std::string& key, double low, double high) const;
  bool flag(const std::string& key) const;  // 0 or 1
  // How an error names an option.
  std::string where(const std::string& key) const;

 private:
  const RepresentationType& type_;
  std::map<std::string, std::string> values_;
};

}  // namespace crowdbench::renderers
