// Based on: Khronos Group, "glTF 2.0 Specification" and the specifications of KHR_mesh_quantization,
// KHR_texture_transform, KHR_materials_unlit and KHR_materials_emissive_strength.
// Differs from the source: what the specification forbids but every engine shows alike (weights without `normalized`,
// colour factors out of range, an animated node with a matrix) is loaded with a warning.
#include "scene/gltf_validate.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "core/error.h"
#include "scene/gltf_document.h"

namespace crowdbench::scene {
namespace {

using nlohmann::json;

constexpr std::array<std::string_view, 4> kKnownExtensions = {"KHR_mesh_quantization", "KHR_texture_transform",
                                                              "KHR_materials_unlit", "KHR_materials_emissive_strength"};

class Validator : GltfDocument {
 public:
  Validator(GltfSource& source, const GltfLimits& limits)
      : GltfDocument(source, limits), source_(source), limits_(limits) {}

  GltfPlan run() {
    check_asset();
    check_extensions();
    // In the order in which later ones refer to earlier ones.
    check_buffers();
    check_buffer_views();
    check_accessors();
    check_images();
    check_samplers();
    check_textures();
    check_materials();
    check_meshes();
    check_skins_and_nodes();
    check_scene();
    check_animations();
    plan_.json = clean_.dump();
    return std::move(plan_);
  }

 private:
  void warn(std::string text) { plan_.warnings.push_back(std::move(text)); }

  // --- the document ---

  void check_asset() {
    const json* asset = member(root(), "asset");
    if (!asset) throw Error(source_.where(), "JSON has no asset, so it is not glTF 2.0");
    require_object(*asset, "/asset");
    const auto major_of = [&](const char* key, bool required) {
      const std::string* version = text_or_none(*asset, "/asset", key);
      if (!version) {
        if (required) fail("/asset", "has no version");
        return std::string("2.0");
      }
      return *version;
    };
    const std::string version = major_of("version", true);
    const bool two = version.size() >= 3 && version.starts_with("2.") &&
                     std::all_of(version.begin() + 2, version.end(), [](char c) { return c >= '0' && c <= '9'; });
    if (!two)
      fail("/asset/version", fmt::format("is {}, not 2.0", printable(version, 20)), "convert the file to glTF 2.0");
    const std::string minimum = major_of("minVersion", false);
    if (minimum != "2.0") fail("/asset/minVersion", fmt::format("is {}; 2.0 is read", printable(minimum, 20)));
    clean_["asset"] = {{"version", "2.0"}};
    // Data is read through the checked accessors; tinygltf only wants to see that indices have a view.
    clean_["bufferViews"] = json::array({{{"buffer", 0}, {"byteLength", 1}}});
  }

  void check_extensions() {
    const auto known = [](const std::string& name) {
      return std::find(kKnownExtensions.begin(), kKnownExtensions.end(), name) != kKnownExtensions.end();
    };
    std::set<std::string> ignored;
    for (const char* key : {"extensionsRequired", "extensionsUsed"}) {
      const json* list = member(root(), key);
      if (!list) continue;
      const std::string path = std::string("/") + key;
      if (!list->is_array()) fail(path, fmt::format("is {}, not an array", list->type_name()));
      for (size_t i = 0; i < list->size(); ++i) {
        if (!(*list)[i].is_string()) fail(item(path, i), "is not a string");
        const auto& name = (*list)[i].get_ref<const std::string&>();
        if (name == "KHR_mesh_quantization") quantized_ = true;
        if (known(name)) continue;
        if (std::string_view(key) == "extensionsRequired")
          fail(item(path, i), fmt::format("requires {}, which is not supported", printable(name, 80)),
               "export the file without it (no mesh or texture compression)");
        ignored.insert(printable(name, 60));
      }
    }
    std::string names;
    size_t listed = 0;
    for (const std::string& name : ignored)
      if (listed++ < 8) names += (names.empty() ? "" : ", ") + name;
    if (!ignored.empty()) warn(fmt::format("extensions ignored: {}{}", names, listed > 8 ? ", ..." : ""));
  }

  void check_buffers() {
    size_t total = 0;
    each("buffers", [&](const json& buffer, const std::string& path) {
      const uint64_t length = required_integer(buffer, path, "byteLength", 1, UINT64_MAX);
      if (length > limits_.file_bytes - total)
        fail(path + "/byteLength", fmt::format("is {}; all buffers may have {} bytes", length, limits_.file_bytes));
      total += length;
      std::span<const uint8_t> bytes;
      if (const std::string* uri = text_or_none(buffer, path, "uri")) {
        plan_.buffers.push_back(source_.fetch(*uri, path + "/uri"));
        bytes = plan_.buffers.back();
      } else if (source_.is_glb() && buffers_.empty()) {
        if (source_.bin().empty()) fail(path, "has no uri and the GLB has no BIN chunk");
        bytes = source_.bin();
      } else {
        fail(path, "has no uri");
      }
      if (bytes.size() < length)
        fail(path + "/byteLength", fmt::format("is {}, but its data has {} bytes", length, bytes.size()),
             "the file is truncated or damaged; get it again");
      buffers_.push_back(bytes.first(length));
    });
  }

  struct View {
    std::span<const uint8_t> bytes;
    size_t offset = 0;  // in its buffer, for alignment
    size_t stride = 0;  // 0: tight
  };

  void check_buffer_views() {
    each("bufferViews", [&](const json& view, const std::string& path) {
      const auto& buffer = buffers_[static_cast<size_t>(required_index(view, path, "buffer", "buffers"))];
      const uint64_t offset = integer_or(view, path, "byteOffset", 0, 0, UINT64_MAX);
      const uint64_t length = required_integer(view, path, "byteLength", 1, UINT64_MAX);
      if (offset > buffer.size() || length > buffer.size() - offset)
        fail(path, fmt::format("byteOffset {} and byteLength {} pass the end of its buffer of {} bytes", offset, length,
                               buffer.size()));
      const uint64_t stride = integer_or(view, path, "byteStride", 0, 4, 252);
      if (stride % 4 != 0) fail(path + "/byteStride", fmt::format("is {}, not a multiple of 4", stride));
      views_.push_back({buffer.subspan(offset, length), static_cast<size_t>(offset), static_cast<size_t>(stride)});
    });
  }

  ComponentType component_type(const json& object, const std::string& path) const {
    switch (required_integer(object, path, "componentType", 0, UINT64_MAX)) {
      case 5120: return kI8;
      case 5121: return kU8;
      case 5122: return kI16;
      case 5123: return kU16;
      case 5125: return kU32;
      case 5126: return kF32;
      default: break;
    }
    fail(path + "/componentType",
         fmt::format("is {}, not one of 5120, 5121, 5122, 5123, 5125, 5126", object["componentType"].dump()));
  }

  // The place of `count` elements of `size` bytes in a view; stride 0 means tight.
  const uint8_t* place(const View& view, const std::string& path, const char* what, uint64_t offset, uint64_t count,
                       size_t size, size_t stride, size_t alignment) const {
    if ((view.offset + offset) % alignment != 0 || offset % alignment != 0)
      fail(path, fmt::format("{} at byte offset {} are not aligned to {} bytes", what, offset, alignment));
    const size_t length = view.bytes.size();
    const uint64_t step = stride == 0 ? size : stride;
    // count - 1 steps and one element, without overflow: step is at most 252.
    if (offset > length || size > length - offset || (count - 1) > (length - offset - size) / step)
      fail(path, fmt::format("{}: {} elements of {} bytes at offset {} pass the end of a view of {} bytes", what, count,
                             size, offset, length));
    return view.bytes.data() + offset;
  }

  void check_accessors() {
    static constexpr std::array<std::pair<std::string_view, int>, 7> kTypes = {
        {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}}};
    each("accessors", [&](const json& accessor, const std::string& path) {
      GltfAccessor out;
      AccessorView& view = out.view;
      view.path = path;
      view.type = component_type(accessor, path);
      const std::string* type = text_or_none(accessor, path, "type");
      if (!type) fail(path, "has no type");
      const auto found = std::find_if(kTypes.begin(), kTypes.end(), [&](const auto& t) { return t.first == *type; });
      if (found == kTypes.end()) fail(path + "/type", fmt::format("is {}, not an accessor type", printable(*type, 20)));
      view.components = found->second;
      view.count = required_integer(accessor, path, "count", 1, UINT32_MAX);
      view.normalized = boolean_or(accessor, path, "normalized", false);
      if (view.normalized && (view.type == kF32 || view.type == kU32))
        fail(path + "/normalized", "is true for a component type that cannot be normalised");
      const size_t component = component_size(view.type);
      size_t size = component * static_cast<size_t>(view.components);
      // Columns of small matrices start at multiples of four bytes.
      if (*type == "MAT2" && component == 1) size = 8;
      if (*type == "MAT3" && component < 4) size = component == 1 ? 12 : 24;
      const uint64_t offset = integer_or(accessor, path, "byteOffset", 0, 0, UINT64_MAX);
      json clean = {{"componentType", accessor["componentType"].get<uint64_t>()},
                    {"type", *type},
                    {"count", view.count},
                    {"normalized", view.normalized}};
      if (const auto index = index_or_none(accessor, path, "bufferView", "bufferViews")) {
        const View& bytes = views_[static_cast<size_t>(*index)];
        if (bytes.stride != 0 && bytes.stride < size)
          fail(path, fmt::format("elements of {} bytes overlap at a byteStride of {}", size, bytes.stride));
        view.base = place(bytes, path, "data", offset, view.count, size, bytes.stride, component);
        view.stride = bytes.stride == 0 ? size : bytes.stride;
        out.has_buffer_view = true;
        clean["bufferView"] = 0;
      } else if (offset != 0) {
        fail(path + "/byteOffset", "is set without a bufferView");
      }
      if (const json* sparse = member(accessor, "sparse")) check_sparse_ranges(*sparse, path + "/sparse", size, view);
      strided_.push_back(out.has_buffer_view && view.stride != size);
      plan_.accessors.push_back(std::move(out));
      clean_["accessors"].push_back(std::move(clean));
    });
  }

  void check_sparse_ranges(const json& sparse, const std::string& path, size_t size, AccessorView& view) {
    require_object(sparse, path);
    view.sparse_count = required_integer(sparse, path, "count", 1, view.count);
    const auto part = [&](const char* key) -> const json& {
      const json* value = member(sparse, key);
      if (!value) fail(path, fmt::format("has no {}", key));
      require_object(*value, path + "/" + key);
      return *value;
    };
    const json& indices = part("indices");
    const std::string indices_path = path + "/indices";
    view.sparse_index_type = component_type(indices, indices_path);
    if (view.sparse_index_type != kU8 && view.sparse_index_type != kU16 && view.sparse_index_type != kU32)
      fail(indices_path + "/componentType", "is not an unsigned integer type");
    const auto bytes_of = [&](const json& object, const std::string& where) -> const View& {
      const View& bytes = views_[static_cast<size_t>(required_index(object, where, "bufferView", "bufferViews"))];
      if (bytes.stride != 0) fail(where + "/bufferView", "names a view with a byteStride");
      return bytes;
    };
    const size_t index_size = component_size(view.sparse_index_type);
    view.sparse_indices = place(bytes_of(indices, indices_path), indices_path, "indices",
                                integer_or(indices, indices_path, "byteOffset", 0, 0, UINT64_MAX), view.sparse_count,
                                index_size, 0, index_size);
    const json& values = part("values");
    const std::string values_path = path + "/values";
    view.sparse_values = place(bytes_of(values, values_path), values_path, "values",
                               integer_or(values, values_path, "byteOffset", 0, 0, UINT64_MAX), view.sparse_count, size,
                               0, component_size(view.type));
  }

  void check_images() {
    each("images", [&](const json& image, const std::string& path) {
      GltfImage out;
      out.path = path;
      const std::string* uri = text_or_none(image, path, "uri");
      const auto view = index_or_none(image, path, "bufferView", "bufferViews");
      if (uri && view) fail(path, "has both a uri and a bufferView");
      if (uri) {
        source_.check_uri(*uri, path + "/uri");
        out.uri = *uri;
      } else if (view) {
        out.bytes = views_[static_cast<size_t>(*view)].bytes;
      }
      plan_.images.push_back(std::move(out));
    });
  }

  void check_samplers() {
    each("samplers", [&](const json& sampler, const std::string& path) {
      json clean = json::object();
      const auto one_of = [&](const char* key, std::initializer_list<uint64_t> allowed) {
        const json* value = member(sampler, key);
        if (!value) return;
        const uint64_t v = integer(*value, path + "/" + key, 0, UINT64_MAX);
        if (std::find(allowed.begin(), allowed.end(), v) == allowed.end())
          fail(path + "/" + key, fmt::format("is {}, which no sampler can be", v));
        clean[key] = v;
      };
      one_of("magFilter", {9728, 9729});
      one_of("minFilter", {9728, 9729, 9984, 9985, 9986, 9987});
      one_of("wrapS", {33071, 33648, 10497});
      one_of("wrapT", {33071, 33648, 10497});
      clean_["samplers"].push_back(std::move(clean));
    });
  }

  void check_textures() {
    each("textures", [&](const json& texture, const std::string& path) {
      json clean = json::object();
      if (const auto source = index_or_none(texture, path, "source", "images")) {
        const GltfImage& image = plan_.images[static_cast<size_t>(*source)];
        if (image.uri.empty() && image.bytes.empty()) fail(image.path, "has neither a uri nor a bufferView");
        clean["source"] = *source;
      }
      if (const auto sampler = index_or_none(texture, path, "sampler", "samplers")) clean["sampler"] = *sampler;
      clean_["textures"].push_back(std::move(clean));
    });
  }

  std::optional<json> texture_info(const json& object, const std::string& parent, const char* key) const {
    const json* info = member(object, key);
    if (!info) return std::nullopt;
    const std::string path = parent + "/" + key;
    require_object(*info, path);
    json clean = {{"index", required_index(*info, path, "index", "textures")},
                  {"texCoord", integer_or(*info, path, "texCoord", 0, 0, 63)}};
    if (const json* transform = extension(*info, path, "KHR_texture_transform")) {
      const std::string at = path + "/extensions/KHR_texture_transform";
      json out = json::object();
      const json* offset = member(*transform, "offset");
      out["offset"] = offset ? numbers(*offset, at + "/offset", 2) : std::vector<double>{0, 0};
      const json* rotation = member(*transform, "rotation");
      out["rotation"] = rotation ? number(*rotation, at + "/rotation") : 0.0;
      const json* scale = member(*transform, "scale");
      out["scale"] = scale ? numbers(*scale, at + "/scale", 2) : std::vector<double>{1, 1};
      clean["texCoord"] = integer_or(*transform, at, "texCoord", clean["texCoord"].get<uint64_t>(), 0, 63);
      clean["extensions"] = {{"KHR_texture_transform", std::move(out)}};
    }
    return clean;
  }

  std::vector<double> colour_factor(const json& value, const std::string& path, size_t count) {
    std::vector<double> factor = numbers(value, path, count);
    for (double& f : factor) {
      if (f < 0 || f > 1) warn(fmt::format("{}: {} is clamped to 0..1", path, f));
      f = std::clamp(f, 0.0, 1.0);
    }
    return factor;
  }

  void check_materials() {
    each("materials", [&](const json& material, const std::string& path) {
      json clean = json::object();
      copy_name(material, path, clean);
      json pbr_clean = json::object();
      if (const json* pbr = member(material, "pbrMetallicRoughness")) {
        const std::string at = path + "/pbrMetallicRoughness";
        require_object(*pbr, at);
        if (const json* factor = member(*pbr, "baseColorFactor"))
          pbr_clean["baseColorFactor"] = colour_factor(*factor, at + "/baseColorFactor", 4);
        if (auto texture = texture_info(*pbr, at, "baseColorTexture")) pbr_clean["baseColorTexture"] = *texture;
      }
      clean["pbrMetallicRoughness"] = std::move(pbr_clean);
      if (const json* factor = member(material, "emissiveFactor"))
        clean["emissiveFactor"] = colour_factor(*factor, path + "/emissiveFactor", 3);
      if (auto texture = texture_info(material, path, "emissiveTexture")) clean["emissiveTexture"] = *texture;
      clean["doubleSided"] = boolean_or(material, path, "doubleSided", false);
      if (const std::string* mode = text_or_none(material, path, "alphaMode")) {
        if (*mode != "OPAQUE" && *mode != "MASK" && *mode != "BLEND")
          fail(path + "/alphaMode", fmt::format("is {}, not OPAQUE, MASK or BLEND", printable(*mode, 20)));
        if (*mode != "OPAQUE") warn(fmt::format("{}: alphaMode {} is drawn opaque", path, *mode));
      }
      json extensions = json::object();
      if (extension(material, path, "KHR_materials_unlit")) extensions["KHR_materials_unlit"] = json::object();
      if (const json* strength = extension(material, path, "KHR_materials_emissive_strength")) {
        const std::string at = path + "/extensions/KHR_materials_emissive_strength";
        const json* value = member(*strength, "emissiveStrength");
        const double v = value ? number(*value, at + "/emissiveStrength") : 1.0;
        if (v < 0) fail(at + "/emissiveStrength", fmt::format("is {}, must not be negative", v));
        extensions["KHR_materials_emissive_strength"] = {{"emissiveStrength", v}};
      }
      if (extension(material, path, "KHR_materials_pbrSpecularGlossiness") && !member(material, "pbrMetallicRoughness"))
        warn(fmt::format("{}: KHR_materials_pbrSpecularGlossiness is ignored, so the material is white", path));
      clean["extensions"] = std::move(extensions);
      clean_["materials"].push_back(std::move(clean));
    });
  }

  // --- meshes ---

  struct MeshSize {
    size_t primitives = 0;  // all modes
    size_t vertices = 0;    // of triangles
    size_t triangles = 0;
  };

  const GltfAccessor& accessor(int index) const { return plan_.accessors[static_cast<size_t>(index)]; }

  // Fails unless the accessor has that many components and one of the formats.
  struct Format {
    ComponentType type;
    int normalized;  // 0, 1; 2 for either
  };
  void require_format(int index, const std::string& path, std::initializer_list<int> components,
                      std::initializer_list<Format> formats) const {
    const AccessorView& view = accessor(index).view;
    if (std::find(components.begin(), components.end(), view.components) == components.end())
      fail(path, fmt::format("names accessor {} with {} components an element", index, view.components));
    for (const Format& f : formats)
      if (f.type == view.type && (f.normalized == 2 || (f.normalized == 1) == view.normalized)) return;
    static constexpr std::array<const char*, 6> kNames = {"signed byte",    "unsigned byte", "signed short",
                                                          "unsigned short", "unsigned int",  "float"};
    fail(path,
         fmt::format("names accessor {} of {}{}, which cannot be used here", index,
                     view.normalized ? "normalised " : "", kNames[view.type]),
         view.type != kF32 && !quantized_ ? "integer positions, normals and uvs need KHR_mesh_quantization" : "");
  }

  void check_attribute(const std::string& name, int index, const std::string& path) {
    const std::initializer_list<Format> any_small = {{kF32, 0}, {kI8, 2}, {kU8, 2}, {kI16, 2}, {kU16, 2}};
    if (name == "POSITION") {
      if (quantized_)
        require_format(index, path, {3}, any_small);
      else
        require_format(index, path, {3}, {{kF32, 0}});
    } else if (name == "NORMAL") {
      if (quantized_)
        require_format(index, path, {3}, {{kF32, 0}, {kI8, 1}, {kI16, 1}});
      else
        require_format(index, path, {3}, {{kF32, 0}});
    } else if (name.starts_with("TEXCOORD_")) {
      if (quantized_)
        require_format(index, path, {2}, any_small);
      else
        require_format(index, path, {2}, {{kF32, 0}, {kU8, 1}, {kU16, 1}});
    } else if (name == "COLOR_0") {
      require_format(index, path, {3, 4}, {{kF32, 0}, {kU8, 1}, {kU16, 1}});
    } else if (name.starts_with("JOINTS_")) {
      require_format(index, path, {4}, {{kU8, 0}, {kU16, 0}});
    } else if (name.starts_with("WEIGHTS_")) {
      require_format(index, path, {4}, {{kF32, 0}, {kU8, 2}, {kU16, 2}});
      const AccessorView& view = accessor(index).view;
      if (view.type != kF32 && !view.normalized && !warned_weights_) {
        warn(fmt::format("{}: integer weights are not marked as normalised; they are taken as such", path));
        warned_weights_ = true;
      }
    }
  }

  void check_meshes() {
    each("meshes", [&](const json& mesh, const std::string& path) {
      json clean = json::object();
      copy_name(mesh, path, clean);
      const json* primitives = member(mesh, "primitives");
      if (!primitives || !primitives->is_array() || primitives->empty()) fail(path, "has no primitives");
      MeshSize size;
      json out = json::array();
      for (size_t i = 0; i < primitives->size(); ++i)
        out.push_back(check_primitive((*primitives)[i], item(path + "/primitives", i), size));
      clean["primitives"] = std::move(out);
      clean_["meshes"].push_back(std::move(clean));
      mesh_sizes_.push_back(size);
    });
  }

  json check_primitive(const json& primitive, const std::string& path, MeshSize& size) {
    require_object(primitive, path);
    const json* attributes = member(primitive, "attributes");
    if (!attributes) fail(path, "has no attributes");
    const std::string at = path + "/attributes";
    require_object(*attributes, at);
    const auto mode = integer_or(primitive, path, "mode", 4, 0, 6);
    json clean = {{"mode", mode}, {"attributes", json::object()}};
    std::optional<size_t> count;
    if (const auto position = index_or_none(*attributes, at, "POSITION", "accessors"))
      count = accessor(*position).view.count;
    int joint_sets = 0;
    int weight_sets = 0;
    for (const auto& [name, value] : attributes->items()) {
      const bool used = name == "POSITION" || name == "NORMAL" || name == "COLOR_0" || name.starts_with("TEXCOORD_") ||
                        name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_");
      const std::string where = at + "/" + printable(name, 60);
      const int index_value = index(value, where, "accessors");
      if (!used) continue;
      check_attribute(name, index_value, where);
      const size_t own = accessor(index_value).view.count;
      if (count && own != *count) fail(where, fmt::format("has {} elements, POSITION has {}", own, *count));
      if (name.starts_with("JOINTS_")) ++joint_sets;
      if (name.starts_with("WEIGHTS_")) ++weight_sets;
      clean["attributes"][name] = index_value;
    }
    if (joint_sets != weight_sets)
      fail(at, fmt::format("has {} sets of joints and {} of weights", joint_sets, weight_sets));
    if (joint_sets > limits_.influence_sets)
      fail(at, fmt::format("has {} sets of joints, {} are read", joint_sets, limits_.influence_sets));
    for (int set = 0; set < joint_sets; ++set)
      for (const char* kind : {"JOINTS_", "WEIGHTS_"})
        if (!attributes->contains(fmt::format("{}{}", kind, set))) fail(at, fmt::format("has no {}{}", kind, set));
    std::optional<size_t> corners = count;
    if (const auto indices = index_or_none(primitive, path, "indices", "accessors")) {
      const std::string where = path + "/indices";
      require_format(*indices, where, {1}, {{kU8, 0}, {kU16, 0}, {kU32, 0}});
      if (!accessor(*indices).has_buffer_view) fail(where, "names an accessor without a bufferView");
      if (strided_[static_cast<size_t>(*indices)]) fail(where, "names an accessor with a byteStride");
      corners = accessor(*indices).view.count;
      clean["indices"] = *indices;
    }
    if (const auto material = index_or_none(primitive, path, "material", "materials")) clean["material"] = *material;
    check_targets(primitive, path);
    ++size.primitives;
    if (mode < 4) {
      if (!warned_lines_) warn(fmt::format("{}: points and lines are not drawn", path));
      warned_lines_ = true;
    } else if (!count) {
      warn(fmt::format("{}: has no POSITION and is not drawn", path));
    } else {
      if (mode == 4 && *corners % 3 != 0)
        fail(path, fmt::format("has {} corners of triangles, not a multiple of 3", *corners));
      if (*corners < 3) fail(path, fmt::format("has {} corners, too few for a triangle", *corners));
      size.vertices += *count;
      size.triangles += mode == 4 ? *corners / 3 : *corners - 2;
    }
    return clean;
  }

  void check_targets(const json& primitive, const std::string& path) {
    const json* targets = member(primitive, "targets");
    if (!targets) return;
    if (!targets->is_array()) fail(path + "/targets", fmt::format("is {}, not an array", targets->type_name()));
    if (!targets->empty() && !warned_targets_) {
      warn(fmt::format("{}: morph targets are ignored", path));
      warned_targets_ = true;
    }
  }

  // --- nodes, skins, scenes ---

  void check_skins_and_nodes() {
    if (count_of("nodes") > limits_.nodes)
      fail("/nodes", fmt::format("has {} nodes, more than the limit of {}", count_of("nodes"), limits_.nodes));
    each("skins", [&](const json& skin, const std::string& path) {
      json clean = json::object();
      copy_name(skin, path, clean);
      const json* joints = member(skin, "joints");
      if (!joints || !joints->is_array() || joints->empty()) fail(path, "has no joints");
      if (joints->size() > limits_.joints)
        fail(path + "/joints", fmt::format("has {} joints, more than the limit of {}", joints->size(), limits_.joints));
      std::set<int> seen;
      for (size_t i = 0; i < joints->size(); ++i) {
        const std::string where = item(path + "/joints", i);
        const int node = index((*joints)[i], where, "nodes");
        if (!seen.insert(node).second) fail(where, fmt::format("names node {} twice", node));
        clean["joints"].push_back(node);
      }
      if (const auto bind = index_or_none(skin, path, "inverseBindMatrices", "accessors")) {
        const std::string where = path + "/inverseBindMatrices";
        require_format(*bind, where, {16}, {{kF32, 0}});
        if (accessor(*bind).view.count < joints->size())
          fail(where, fmt::format("has {} matrices for {} joints", accessor(*bind).view.count, joints->size()));
        clean["inverseBindMatrices"] = *bind;
      }
      if (const auto root = index_or_none(skin, path, "skeleton", "nodes")) clean["skeleton"] = *root;
      clean_["skins"].push_back(std::move(clean));
    });
    const size_t nodes = count_of("nodes");
    plan_.node_parent.assign(nodes, -1);
    children_.resize(nodes);
    size_t node = 0;
    each("nodes", [&](const json& object, const std::string& path) { check_node(object, path, node++); });
    order_nodes();
  }

  void check_node(const json& node, const std::string& path, size_t self) {
    json clean = json::object();
    copy_name(node, path, clean);
    const auto copy = [&](const char* key, size_t count) {
      const json* value = member(node, key);
      if (!value) return false;
      clean[key] = numbers(*value, path + "/" + key, count);
      return true;
    };
    const bool matrix = copy("matrix", 16);
    const bool moved = copy("translation", 3);
    const bool scaled = copy("scale", 3);
    const bool turned = copy("rotation", 4);
    if (matrix && (moved || scaled || turned)) fail(path, "has both a matrix and a translation, rotation or scale");
    if (matrix) {
      const json& m = clean["matrix"];
      if (m[3] != 0.0 || m[7] != 0.0 || m[11] != 0.0 || m[15] != 1.0) fail(path + "/matrix", "is not affine");
    }
    if (turned) {
      double square = 0;
      for (const json& c : clean["rotation"]) square += c.get<double>() * c.get<double>();
      if (square < 1e-12) fail(path + "/rotation", "is a quaternion of length zero");
    }
    if (const json* children = member(node, "children")) {
      const std::string where = path + "/children";
      if (!children->is_array()) fail(where, fmt::format("is {}, not an array", children->type_name()));
      for (size_t i = 0; i < children->size(); ++i) {
        const int child = index((*children)[i], item(where, i), "nodes");
        int& parent = plan_.node_parent[static_cast<size_t>(child)];
        if (static_cast<size_t>(child) == self) fail(item(where, i), fmt::format("makes node {} its own child", child));
        if (parent >= 0)
          fail(item(where, i), fmt::format("node {} has two parents, nodes {} and {}", child, parent, self));
        parent = static_cast<int>(self);
        children_[self].push_back(child);
      }
    }
    const auto mesh = index_or_none(node, path, "mesh", "meshes");
    const auto skin = index_or_none(node, path, "skin", "skins");
    if (mesh) clean["mesh"] = *mesh;
    if (mesh && skin) clean["skin"] = *skin;
    node_mesh_.push_back(mesh.value_or(-1));
    node_skin_.push_back(mesh && skin ? *skin : -1);
    if (mesh && skin) check_skinned(*mesh, path);
    clean_["nodes"].push_back(std::move(clean));
  }

  void check_skinned(int mesh, const std::string& path) {
    if (!skinned_checked_.insert(mesh).second) return;
    const json& primitives = clean_["meshes"][static_cast<size_t>(mesh)]["primitives"];
    for (size_t i = 0; i < primitives.size(); ++i)
      if (primitives[i]["mode"].get<int>() >= 4 && !primitives[i]["attributes"].contains("JOINTS_0"))
        fail(fmt::format("/meshes/{}/primitives/{}/attributes", mesh, i),
             fmt::format("has no JOINTS_0, but {} gives it a skin", path));
  }

  void order_nodes() {
    const size_t nodes = children_.size();
    std::vector<int> stack;
    for (size_t i = nodes; i-- > 0;)
      if (plan_.node_parent[i] < 0) stack.push_back(static_cast<int>(i));
    while (!stack.empty()) {
      const int node = stack.back();
      stack.pop_back();
      plan_.node_order.push_back(node);
      const std::vector<int>& below = children_[static_cast<size_t>(node)];
      stack.insert(stack.end(), below.rbegin(), below.rend());
    }
    if (plan_.node_order.size() == nodes) return;
    // Every node has one parent at most, so what no root reaches is a cycle and what hangs from it.
    std::vector<bool> reached(nodes, false);
    for (const int node : plan_.node_order) reached[static_cast<size_t>(node)] = true;
    const auto lost = static_cast<size_t>(std::find(reached.begin(), reached.end(), false) - reached.begin());
    fail(fmt::format("/nodes/{}", lost), "belongs to a cycle of parents and children");
  }

  void check_scene() {
    const size_t nodes = children_.size();
    plan_.in_scene.assign(nodes, false);
    std::vector<int> roots;
    bool first = true;
    const auto wanted = index_or_none(root(), "", "scene", "scenes").value_or(0);
    size_t scene_index = 0;
    each("scenes", [&](const json& scene, const std::string& path) {
      first = false;
      const bool chosen = scene_index++ == static_cast<size_t>(wanted);
      const json* list = member(scene, "nodes");
      if (!list) return;
      if (!list->is_array()) fail(path + "/nodes", fmt::format("is {}, not an array", list->type_name()));
      std::set<int> seen;
      for (size_t i = 0; i < list->size(); ++i) {
        const std::string where = item(path + "/nodes", i);
        const int node = index((*list)[i], where, "nodes");
        if (!seen.insert(node).second) fail(where, fmt::format("names node {} twice", node));
        const int parent = plan_.node_parent[static_cast<size_t>(node)];
        if (parent >= 0) fail(where, fmt::format("names node {}, which is a child of node {}", node, parent));
        if (chosen) roots.push_back(node);
      }
    });
    if (first) {
      if (nodes != 0) warn("has no scene; every root node is shown");
      for (size_t i = 0; i < nodes; ++i)
        if (plan_.node_parent[i] < 0) roots.push_back(static_cast<int>(i));
    }
    for (const int root : roots) plan_.in_scene[static_cast<size_t>(root)] = true;
    for (const int node : plan_.node_order) {
      const int parent = plan_.node_parent[static_cast<size_t>(node)];
      if (parent >= 0 && plan_.in_scene[static_cast<size_t>(parent)]) plan_.in_scene[static_cast<size_t>(node)] = true;
    }
    check_totals();
  }

  // Counts before anything is allocated: a mesh on many nodes multiplies.
  void check_totals() {
    size_t primitives = 0;
    std::set<int> skins;
    size_t palette = 0;
    for (size_t i = 0; i < node_mesh_.size(); ++i) {
      if (node_mesh_[i] < 0 || !plan_.in_scene[i]) continue;
      const std::string path = fmt::format("/nodes/{}", i);
      const MeshSize& size = mesh_sizes_[static_cast<size_t>(node_mesh_[i])];
      primitives += size.primitives;
      plan_.vertices += size.vertices;
      plan_.triangles += size.triangles;
      const auto bound = [&](size_t have, size_t limit, const char* what) {
        if (have > limit) fail(path, fmt::format("brings the scene to {} {}, the limit is {}", have, what, limit));
      };
      bound(primitives, limits_.primitives, "primitives");
      bound(plan_.vertices, limits_.vertices, "vertices");
      bound(plan_.triangles, limits_.triangles, "triangles");
      if (node_skin_[i] < 0) {
        ++palette;
      } else if (skins.insert(node_skin_[i]).second) {
        palette += clean_["skins"][static_cast<size_t>(node_skin_[i])]["joints"].size();
      }
      bound(palette, limits_.joints, "joints and rigid meshes");
    }
  }

  // --- animations ---

  void check_animations() {
    if (count_of("animations") > limits_.clips)
      fail("/animations", fmt::format("has {} clips, the limit is {}", count_of("animations"), limits_.clips));
    each("animations", [&](const json& animation, const std::string& path) { check_animation(animation, path); });
  }

  const json& list_of(const json& object, const std::string& path, const char* key) const {
    const json* list = member(object, key);
    if (!list) fail(path, fmt::format("has no {}", key));
    if (!list->is_array()) fail(path + "/" + key, fmt::format("is {}, not an array", list->type_name()));
    return *list;
  }

  void check_animation(const json& animation, const std::string& path) {
    json clean = json::object();
    copy_name(animation, path, clean);
    clean["samplers"] = json::array();
    clean["channels"] = json::array();
    const json& samplers = list_of(animation, path, "samplers");
    for (size_t i = 0; i < samplers.size(); ++i) {
      const std::string at = item(path + "/samplers", i);
      require_object(samplers[i], at);
      const int input = required_index(samplers[i], at, "input", "accessors");
      const int output = required_index(samplers[i], at, "output", "accessors");
      require_format(input, at + "/input", {1}, {{kF32, 0}});
      std::string interpolation = "LINEAR";
      if (const std::string* given = text_or_none(samplers[i], at, "interpolation")) interpolation = *given;
      if (interpolation != "LINEAR" && interpolation != "STEP" && interpolation != "CUBICSPLINE")
        fail(at + "/interpolation",
             fmt::format("is {}, not LINEAR, STEP or CUBICSPLINE", printable(interpolation, 20)));
      clean["samplers"].push_back({{"input", input}, {"output", output}, {"interpolation", interpolation}});
    }
    std::set<std::pair<int, std::string>> targets;
    const json& channels = list_of(animation, path, "channels");
    for (size_t i = 0; i < channels.size(); ++i)
      check_channel(channels[i], item(path + "/channels", i), samplers.size(), targets, clean);
    clean_["animations"].push_back(std::move(clean));
  }

  void check_channel(const json& channel, const std::string& path, size_t samplers,
                     std::set<std::pair<int, std::string>>& targets, json& clean) {
    require_object(channel, path);
    const uint64_t sampler = required_integer(channel, path, "sampler", 0, UINT64_MAX);
    if (sampler >= samplers)
      fail(path + "/sampler", fmt::format("is {}, but there are {} samplers", sampler, samplers));
    const json* target = member(channel, "target");
    if (!target) fail(path, "has no target");
    const std::string at = path + "/target";
    require_object(*target, at);
    const std::string* what = text_or_none(*target, at, "path");
    if (!what) fail(at, "has no path");
    const auto node = index_or_none(*target, at, "node", "nodes");
    if (*what == "weights") {
      if (!warned_targets_) warn(fmt::format("{}: morph targets are ignored", path));
      warned_targets_ = true;
      return;
    }
    if (*what == "pointer" || !node) {
      if (!warned_pointer_) warn(fmt::format("{}: has no node to move and is ignored", path));
      warned_pointer_ = true;
      return;
    }
    if (*what != "translation" && *what != "rotation" && *what != "scale")
      fail(at + "/path", fmt::format("is {}, not translation, rotation, scale or weights", printable(*what, 20)));
    if (!targets.emplace(*node, *what).second)
      fail(at, fmt::format("is the second channel of this clip for the {} of node {}", *what, *node));
    const json& curve = clean["samplers"][sampler];
    const AccessorView& input = accessor(curve["input"].get<int>()).view;
    const int output_index = curve["output"].get<int>();
    const std::string sampler_path = path.substr(0, path.rfind("/channels/")) + fmt::format("/samplers/{}", sampler);
    if (*what == "rotation")
      require_format(output_index, sampler_path + "/output", {4},
                     {{kF32, 0}, {kI8, 1}, {kU8, 1}, {kI16, 1}, {kU16, 1}});
    else
      require_format(output_index, sampler_path + "/output", {3}, {{kF32, 0}});
    const AccessorView& output = accessor(output_index).view;
    const size_t per_key = curve["interpolation"] == "CUBICSPLINE" ? 3 : 1;
    if (output.count != input.count * per_key)
      fail(sampler_path,
           fmt::format("output has {} values, {} keys need {}", output.count, input.count, input.count * per_key));
    keys_ += input.count + output.count * static_cast<size_t>(output.components);
    if (keys_ > limits_.keys)
      fail(path, fmt::format("brings the animations to {} numbers, the limit is {}", keys_, limits_.keys));
    clean["channels"].push_back({{"sampler", sampler}, {"target", {{"node", *node}, {"path", *what}}}});
  }

  GltfSource& source_;
  const GltfLimits& limits_;
  json clean_ = json::object();
  GltfPlan plan_;
  bool quantized_ = false;
  bool warned_weights_ = false;
  bool warned_lines_ = false;
  bool warned_targets_ = false;
  bool warned_pointer_ = false;
  std::vector<std::span<const uint8_t>> buffers_;
  std::vector<View> views_;
  std::vector<bool> strided_;  // by accessor
  std::vector<MeshSize> mesh_sizes_;
  std::vector<std::vector<int>> children_;
  std::vector<int> node_mesh_;
  std::vector<int> node_skin_;
  std::set<int> skinned_checked_;
  size_t keys_ = 0;
};

}  // namespace

GltfPlan validate_gltf(GltfSource& source, const GltfLimits& limits) { return Validator(source, limits).run(); }

void check_sparse(const AccessorView& view, const GltfSource& source) {
  for (size_t i = 0; i < view.sparse_count; ++i) {
    const size_t index = view.sparse_index(i);
    const std::string path = view.path + "/sparse/indices";
    if (index >= view.count) source.fail(path, fmt::format("index {} is {}, of {} elements", i, index, view.count));
    if (i > 0 && index <= view.sparse_index(i - 1))
      source.fail(path, fmt::format("index {} is {}, not above the one before it", i, index));
  }
}

}  // namespace crowdbench::scene
