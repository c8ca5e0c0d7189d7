#include "scene/assimp/assimp.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <map>
#include <string_view>

#include "core/error.h"
#include "core/module.h"
#include "scene/assimp/isolated.h"
#include "scene/assimp/module/assimp_api.h"

namespace crowdbench::scene {
namespace {

namespace fs = std::filesystem;
using assimp_module::Item;
using assimp_module::Picture;

constexpr const char* kExportAgain = "export the character again (FBX 2011 or later), or convert it to glTF";

const assimp_module::Api& api() {
  static const assimp_module::Api& loaded = []() -> const assimp_module::Api& {
    const auto function = [] {
      try {
        return reinterpret_cast<assimp_module::ApiFunction>(
            module_symbol("assimp", assimp_module::kApiSymbol, "reading FBX and COLLADA"));
      } catch (const Error& error) {
        if (error.wrong.find("libassimp") == std::string::npos) throw;
        throw Error(error.where, error.wrong, "install Debian's package libassimp5, or convert the character to glTF");
      }
    }();
    const assimp_module::Api& found = *function();
    if (found.version != assimp_module::kApiVersion)
      throw Error("crowdbench_assimp.so", "is of another version than the program", "rebuild with ./run build");
    return found;
  }();
  return loaded;
}

// --- in the child ---

struct InChild {
  int fd;
  fs::path folder;  // real, empty: no pictures
  std::string stem;
};

void write_all(int fd, const void* data, size_t size) {
  const auto* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t written = ::write(fd, at, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) ::_exit(1);
    at += written;
    size -= static_cast<size_t>(written);
  }
}

void write_item(void* context, Item item, const char* data, size_t size) {
  const int fd = static_cast<const InChild*>(context)->fd;
  const std::array<uint64_t, 2> head = {static_cast<uint64_t>(item), size};
  write_all(fd, head.data(), sizeof head);
  write_all(fd, data, size);
}

Picture judge(std::string_view start) {
  const bool png = start.starts_with("\x89PNG\r\n\x1A\n");
  const bool jpeg = start.starts_with("\xFF\xD8\xFF");
  const bool webp = start.starts_with("RIFF") && start.size() >= 12 && start.substr(8, 4) == "WEBP";
  return png || jpeg || webp ? Picture::readable : Picture::unreadable;
}

Picture judge_picture(void* /*context*/, const uint8_t* bytes, size_t size) {
  return judge({reinterpret_cast<const char*>(bytes), std::min<size_t>(size, 16)});
}

bool lies_below(const fs::path& real, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), real.begin(), real.end()).first == folder.end();
}

// As glTF writes it: what is neither a letter nor a digit nor one of these is escaped.
std::string uri_of(const std::string& path) {
  std::string out;
  for (const char c : path) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || std::strchr("/._-", c) != nullptr)
      out += c;
    else
      out += fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return out;
}

// Where the picture of that path may lie, below the folder.
std::vector<fs::path> places_of(std::string path, const std::string& stem) {
  std::replace(path.begin(), path.end(), '\\', '/');
  if (path.starts_with("file://")) path.erase(0, 7);
  while (path.starts_with("./")) path.erase(0, 2);
  const fs::path name = fs::path(path).filename();
  return {path, name, fs::path("textures") / name, fs::path(stem + ".fbm") / name};
}

Picture find_picture(void* context, const char* path, char* uri) {
  const auto& child = *static_cast<const InChild*>(context);
  if (child.folder.empty()) return Picture::missing;
  for (const fs::path& place : places_of(path, child.stem)) {
    if (place.empty() || place.is_absolute()) continue;
    std::error_code error;
    const fs::path real = fs::canonical(child.folder / place, error);
    if (error || !lies_below(real, child.folder) || !fs::is_regular_file(real, error)) continue;
    const std::string text = uri_of(real.lexically_relative(child.folder).generic_string());
    if (text.size() >= assimp_module::kUriBytes) continue;
    std::array<char, 16> start{};
    std::ifstream file(real, std::ios::binary);
    file.read(start.data(), start.size());
    std::copy_n(text.c_str(), text.size() + 1, uri);
    return judge({start.data(), static_cast<size_t>(file.gcount())});
  }
  return Picture::missing;
}

// --- in the parent ---

struct Converted {
  std::vector<uint8_t> glb;
  std::vector<std::string> warnings;
  std::map<std::string, std::string, std::less<>> labels;  // by path of the document: "/nodes/3"
  std::string refusal;
};

constexpr size_t kMostWarnings = 32;
constexpr uint64_t kMostBesides = uint64_t{64} << 20;  // bytes of warnings and labels

void add_item(Converted& out, Item item, std::string_view text) {
  switch (item) {
    case Item::refusal: out.refusal = text; break;
    case Item::warning:
      if (out.warnings.size() < kMostWarnings) out.warnings.push_back(printable(text, 400));
      if (out.warnings.size() == kMostWarnings) out.warnings.back() = "there are further warnings";
      break;
    case Item::glb: out.glb.assign(text.begin(), text.end()); break;
    case Item::label:
      if (const size_t tab = text.find('\t'); tab != std::string_view::npos)
        out.labels.emplace(text.substr(0, tab), printable(text.substr(tab + 1), 200));
      break;
  }
}

// A child that was hit by the file may have written anything: false where the items do not follow each other.
bool read_items(const std::vector<uint8_t>& bytes, Converted& out) {
  size_t at = 0;
  while (at < bytes.size()) {
    std::array<uint64_t, 2> head{};
    if (bytes.size() - at < sizeof head) return false;
    std::memcpy(head.data(), &bytes[at], sizeof head);
    at += sizeof head;
    if (head[0] > static_cast<uint64_t>(Item::glb) || head[1] > bytes.size() - at) return false;
    add_item(out, static_cast<Item>(head[0]), {reinterpret_cast<const char*>(bytes.data()) + at, head[1]});
    at += head[1];
  }
  return !out.glb.empty() || !out.refusal.empty();
}

assimp_module::Limits limits_of(const GltfLimits& l) { return {l.nodes, l.triangles, l.keys, l.clips, l.clip_nodes}; }

Converted convert(const std::vector<uint8_t>& bytes, AssimpFormat format, const std::string& where,
                  const fs::path& folder, const GltfLimits& limits) {
  const assimp_module::Api& module = api();
  std::error_code ignored;
  InChild child{-1, folder.empty() ? fs::path() : fs::canonical(folder, ignored), fs::path(where).stem().string()};
  const auto work = [&](int fd) {
    child.fd = fd;
    const assimp_module::Request request = {bytes.data(),      bytes.size(), static_cast<assimp_module::Format>(format),
                                            limits_of(limits), &child,       find_picture,
                                            judge_picture,     write_item};
    module.convert(&request);
  };
  IsolationLimits isolation;
  isolation.output_bytes = limits.file_bytes + kMostBesides;
  const IsolatedOutput output = run_isolated("reading " + printable(where, 80), work, isolation);
  Converted out;
  const bool whole = read_items(output.bytes, out);
  if (!output.failure.empty()) throw Error(printable(where, 300), output.failure, kExportAgain);
  if (!whole) throw Error(printable(where, 300), "comes out of Assimp broken", kExportAgain);
  if (!out.refusal.empty()) throw Error(printable(where, 300), printable(out.refusal, 300), kExportAgain);
  return out;
}

// The end of a path of the document that begins at `at` with "/list/number"; `at` itself where none does.
size_t path_end(std::string_view text, size_t at, size_t& element) {
  const auto word = [&](size_t i, auto&& of) {
    while (i < text.size() && of(static_cast<unsigned char>(text[i]))) ++i;
    return i;
  };
  const size_t list = word(at + 1, [](unsigned char c) { return std::isalpha(c) != 0; });
  if (list == at + 1 || list >= text.size() || text[list] != '/') return at;
  element = word(list + 1, [](unsigned char c) { return std::isdigit(c) != 0; });
  if (element == list + 1) return at;
  return word(element, [](unsigned char c) { return std::isalnum(c) != 0 || c == '/' || c == '_'; });
}

// The document's paths, which nobody has seen, become what they stand for: "/nodes/3/rotation" "node Hips".
std::string readable(std::string_view text, const Converted& from) {
  std::string out;
  for (size_t i = 0; i < text.size();) {
    size_t element = i;
    const size_t end = text[i] == '/' ? path_end(text, i, element) : i;
    const auto label = end > i ? from.labels.find(text.substr(i, element - i)) : from.labels.end();
    if (label == from.labels.end()) {
      out += text[i++];
      continue;
    }
    out += label->second;
    i = end;
  }
  return out;
}

}  // namespace

std::optional<AssimpFormat> assimp_format(std::span<const uint8_t> start, const fs::path& path) {
  const std::string_view text(reinterpret_cast<const char*>(start.data()), start.size());
  if (text.starts_with("Kaydara FBX Binary") || text.starts_with("; FBX")) return AssimpFormat::fbx;
  const size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  if (first != std::string_view::npos && text[first] == '<' && text.find("<COLLADA") != std::string_view::npos)
    return AssimpFormat::collada;
  if (text.starts_with("glTF") || (first != std::string_view::npos && text[first] == '{')) return std::nullopt;
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".fbx") return AssimpFormat::fbx;
  if (extension == ".dae") return AssimpFormat::collada;
  return std::nullopt;
}

Character load_assimp_character(const std::vector<uint8_t>& bytes, AssimpFormat format, const std::string& where,
                                const fs::path& folder, const LoadOptions& options) {
  if (bytes.size() > options.limits.file_bytes)
    throw Error(printable(where, 300),
                fmt::format("is {} bytes, more than the limit of {}", bytes.size(), options.limits.file_bytes),
                "use a smaller character");
  const Converted converted = convert(bytes, format, where, folder, options.limits);
  LoadOptions own = options;
  own.limits.json_values *= 4;  // of a document that is ours; its lists are bounded
  try {
    Character character = load_character(converted.glb, where, folder, own);
    for (std::string& warning : character.warnings) warning = readable(warning, converted);
    character.warnings.insert(character.warnings.begin(), converted.warnings.begin(), converted.warnings.end());
    return character;
  } catch (const Error& error) {
    const bool of_gltf = error.advice.find("glTF") != std::string::npos;
    throw Error(readable(error.where, converted), readable(error.wrong, converted),
                of_gltf ? kExportAgain : error.advice);
  }
}

}  // namespace crowdbench::scene
