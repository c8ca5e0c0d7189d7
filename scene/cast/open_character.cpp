#include "scene/cast/open_character.h"

#include <algorithm>
#include <charconv>
#include <span>

#include "core/error.h"
#include "core/files.h"
#include "scene/assimp/assimp.h"
#include "scene/mannequin/mannequin.h"

namespace crowdbench::scene {
namespace {

int whole_number(std::string_view key, std::string_view text) {
  int value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || stop != text.data() + text.size())
    throw Error("mannequin", fmt::format("{}={} is not a whole number", key, printable(text, 40)),
                "write mannequin:triangles=500|2200|5000,joints=20|53");
  return value;
}

Character open_file(const std::filesystem::path& path, const LoadOptions& options) {
  const std::vector<uint8_t> bytes = read_file(path, options.limits.file_bytes);
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  const auto format = assimp_format(std::span(bytes).first(std::min<size_t>(bytes.size(), 4096)), path);
  return format ? load_assimp_character(bytes, *format, path.string(), folder, options)
                : load_character(bytes, path.string(), folder, options);
}

}  // namespace

Character open_character(const std::string& name_or_path, const LoadOptions& options) {
  constexpr std::string_view kBuiltIn = "mannequin";
  const std::string_view name = name_or_path;
  if (name != kBuiltIn && !name.starts_with("mannequin:")) return open_file(name_or_path, options);
  MannequinOptions mannequin;
  mannequin.normalise = options.normalise;
  std::string_view rest = name.size() > kBuiltIn.size() ? name.substr(kBuiltIn.size() + 1) : std::string_view{};
  while (!rest.empty()) {
    const std::string_view one = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(rest.size(), one.size() + 1));
    const size_t equals = one.find('=');
    const std::string_view key = one.substr(0, equals);
    const std::string_view value = equals == std::string_view::npos ? std::string_view{} : one.substr(equals + 1);
    if (key == "triangles")
      mannequin.triangles = whole_number(key, value);
    else if (key == "joints")
      mannequin.joints = whole_number(key, value);
    else
      throw Error("mannequin", fmt::format("has no option {}", printable(key, 40)), "it has triangles and joints");
  }
  if (!options.hide.empty())
    throw Error("mannequin", fmt::format("has no node named {} to hide", printable(options.hide.front(), 60)),
                "it is one mesh");
  return make_mannequin(mannequin);
}

}  // namespace crowdbench::scene
