// The rooms and which way their doors open: every include of the tree is held to the arrows, and every header that
// another folder includes has a test.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "test_paths.h"
#include "tests/support/sanitized.h"

namespace crowdbench {
namespace {
namespace fs = std::filesystem;

using Strings = std::vector<std::string>;

using Doors = std::map<std::string, std::set<std::string>>;

// room -> the rooms that it may include besides itself.
const Doors& doors() {
  static const Doors all = {
      {"core", {}},
      {"store", {"core"}},
      {"scene", {"core"}},
      {"truth", {"core", "scene"}},
      {"renderers", {"core", "scene"}},
      {"metrics", {"core"}},
      {"studies", {"core", "store", "scene", "renderers", "metrics"}},
      {"reports", {"core", "store"}},
      {"bench", {"core", "store", "scene", "renderers", "metrics", "studies", "reports", "truth"}},
  };
  return all;
}

// Folders that are libraries of their own and know less than their room does -> the other rooms that they may include.
const Doors& narrow_doors() {
  static const Doors all = {
      {"studies/analysis", {"core"}}, {"studies/page", {"core"}}, {"studies/server", {"core", "store"}}};
  return all;
}

// Inside the big rooms: folder -> the folders of the same room that it may include. "" is the room's own files:
// in renderers/ the interface and the registry. CONTRIBUTING says the same in words.
const std::map<std::string, Doors>& inner_doors() {
  static const std::map<std::string, Doors> all = {
      {"scene",
       {{"character", {}},
        {"pose", {"character"}},
        {"gltf", {"character", "pose"}},
        {"assimp", {"character", "pose", "gltf"}},
        {"mannequin", {"character", "pose"}},
        {"frame", {"character", "pose"}},
        {"scenario", {"character", "frame"}},
        {"cast", {"character", "pose", "gltf", "assimp", "mannequin", "scenario"}},
        {"crowd", {"character", "pose", "frame", "scenario", "cast"}}}},
      {"renderers",
       {{"", {"mesh"}},  // and every representation: the registry
        {"shaders", {}},
        {"gl", {"shaders"}},
        {"frame", {"", "gl", "shaders"}},
        {"bake", {"", "gl"}},
        {"mesh", {"", "gl", "shaders", "frame", "bake"}},  // what is captured, so that impostors may know it
        {"impostor", {"", "gl", "shaders", "frame", "bake", "mesh"}}}},
      {"studies",
       {{"stimuli", {}}, {"analysis", {}}, {"page", {}}, {"server", {}}, {"plan", {"stimuli", "analysis", "page"}}}},
      {"bench",
       {{"", {"commands"}},
        {"speed", {}},
        {"stage", {}},
        {"timing", {"stage"}},
        {"experiments", {"stage", "timing"}},
        {"sweep", {"stage", "timing", "experiments"}},
        {"stability", {"stage", "sweep"}},
        {"commands", {"stage", "timing", "experiments", "sweep", "stability"}}}},
      {"reports", {{"model", {}}, {"charts", {"model"}}, {"exports", {"model"}}, {"page", {"model", "charts"}}}},
  };
  return all;
}

// A folder of renderers/ that is not named above is a representation: it may include what they all share, and others
// only as stated here. Nobody but the registry includes it.
const std::set<std::string>& representation_doors() {
  static const std::set<std::string> shared = {"", "gl", "shaders", "frame", "bake", "impostor"};
  return shared;
}
const Doors& doors_between_representations() {
  static const Doors all = {{"dynamic", {"mesh"}},    {"layered", {"flat"}}, {"posecache", {"mesh"}},
                            {"preskinned", {"mesh"}}, {"pseudo", {"mesh"}},  {"rigid", {"mesh"}},
                            {"surfel", {"mesh"}}};
  return all;
}

// Whether the folder states no direction: of a room other than renderers/.
bool is_unknown(const std::string& room, const std::string& folder) {
  return room != "renderers" && !inner_doors().at(room).contains(folder);
}

bool may_include(const std::string& room, const std::string& from, const std::string& into) {
  const Doors& inner = inner_doors().at(room);
  if (from == into || (inner.contains(from) && inner.at(from).contains(into))) return true;
  if (room != "renderers") return false;
  if (from.empty()) return !inner.contains(into);
  const auto extra = doors_between_representations().find(from);
  return !inner.contains(from) && (representation_doors().contains(into) ||
                                   (extra != doors_between_representations().end() && extra->second.contains(into)));
}

// Libraries whose headers are slow to compile or drag a platform in: in sources only.
const Strings kHeavy = {"nlohmann/json.hpp", "CLI/",  "tiny_gltf.h", "toml.hpp",  "OpenImageIO/", "libavcodec/",
                        "libavformat/",      "GLFW/", "EGL/",        "sqlite3.h", "nlopt.h",      "httplib.h"};

std::string room_of(const std::string& path) { return path.substr(0, path.find('/')); }
// "scene/pose/pose.h" is in "pose"; "renderers/registry.cpp" in "".
std::string folder_of(const std::string& path) {
  const size_t first = path.find('/');
  const size_t second = path.find('/', first + 1);
  return second == std::string::npos ? "" : path.substr(first + 1, second - first - 1);
}
bool starts_with(const std::string& text, const std::string& start) { return text.rfind(start, 0) == 0; }

// Comments become spaces; line breaks stay.
std::string without_comments(const std::string& text) {
  std::string out = text;
  for (size_t i = 0; i + 1 < out.size(); ++i) {
    if (out[i] == '"' || out[i] == '\'') {
      const char quote = out[i];
      for (++i; i < out.size() && out[i] != quote && out[i] != '\n'; ++i) {
        if (out[i] == '\\') ++i;
      }
    } else if (out[i] == '/' && out[i + 1] == '/') {
      for (; i < out.size() && out[i] != '\n'; ++i) out[i] = ' ';
    } else if (out[i] == '/' && out[i + 1] == '*') {
      for (; i < out.size() && !(out[i] == '*' && i + 1 < out.size() && out[i + 1] == '/'); ++i) {
        if (out[i] != '\n') out[i] = ' ';
      }
      if (i + 1 < out.size()) out[i] = out[i + 1] = ' ';
    }
  }
  return out;
}

// The faults of one file, each "path:line: what". path: below the repository, with '/'.
Strings faults_of(const std::string& path, const std::string& text) {
  static const std::regex include(R"re(^\s*#\s*include\s*(["<])([^">]+)[">])re");
  static const std::regex raw_gl(R"(\bgl(Gen|Create|Delete)[A-Z]\w*\s*\()");
  const std::string room = room_of(path);
  const bool header = path.size() > 2 && path.substr(path.size() - 2) == ".h";
  const bool shared = path.size() > 9 && path.substr(path.size() - 9) == ".shared.h";
  const bool in_gl = starts_with(path, "renderers/gl/");
  Strings faults;
  int number = 0;
  const auto fault = [&](const std::string& what) {
    faults.push_back(path + ":" + std::to_string(number) + ": " + what);
  };
  std::istringstream original(text);
  std::istringstream bare(without_comments(text));
  std::string line;
  std::string code;
  bool once = false;
  while (std::getline(original, line) && std::getline(bare, code)) {
    ++number;
    // Headers that C++ shares with GLSL cannot use the pragma.
    once = once || starts_with(code, "#pragma once") || (shared && starts_with(code, "#ifndef CROWDBENCH_"));
    std::smatch match;
    if (std::regex_search(code, match, include)) {
      const std::string target = match[2];
      const std::string to = room_of(target);
      if (match[1] == "\"") {
        if (!doors().contains(to)) {
          fault("includes \"" + target + "\", which is not a path from the repository's root");
        } else if (to != room && !doors().at(room).contains(to)) {
          fault("includes \"" + target + "\": " + room + " may not know " + to);
        } else if (const auto narrow = narrow_doors().find(room + "/" + folder_of(path));
                   to != room && narrow != narrow_doors().end() && !narrow->second.contains(to)) {
          fault("includes \"" + target + "\": " + narrow->first + " may not know " + to);
        } else if (to == room && inner_doors().contains(room)) {
          const std::string from = folder_of(path);
          const std::string into = folder_of(target);
          if (is_unknown(room, from)) {
            fault("lies in " + room + "/" + from + ", which states no direction of includes");
          } else if (!may_include(room, from, into)) {
            fault("includes \"" + target + "\": " + room + "/" + from + " may not know " + room + "/" + into);
          }
        }
      }
      if (header) {
        for (const std::string& heavy : kHeavy) {
          if (starts_with(target, heavy)) fault("a header includes <" + target + ">, which belongs into sources");
        }
      }
      const bool gl = starts_with(target, "epoxy/") || starts_with(target, "GLFW/") || starts_with(target, "EGL/");
      if (gl && room != "renderers") fault("includes <" + target + "> outside renderers/");
    }
    if (!in_gl && std::regex_search(code, match, raw_gl)) {
      fault("calls " + match[0].str() + "...) outside renderers/gl/");
    }
  }
  if (header && !once) {
    number = 1;
    fault("has no #pragma once");
  }
  return faults;
}

std::string read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Includes, FollowTheArrows) {
  CROWDBENCH_SKIP_SANITIZED("CheckerFindsEveryKindOfFault");
  const fs::path root = CROWDBENCH_SOURCE_DIR;
  size_t files = 0;
  size_t rooms = 0;
  for (const auto& [room, ignored] : doors()) {
    ASSERT_TRUE(fs::is_directory(root / room)) << room;
    ++rooms;
    for (const auto& entry : fs::recursive_directory_iterator(root / room)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".h" && extension != ".cpp") continue;
      ++files;
      const std::string path = entry.path().lexically_relative(root).generic_string();
      for (const std::string& fault : faults_of(path, read(entry.path()))) ADD_FAILURE() << fault;
    }
  }
  EXPECT_EQ(rooms, 9U);
  EXPECT_GT(files, 40U);  // the walk found the tree
}

// The checker itself: each of its faults, on made-up files.
TEST(Includes, CheckerFindsEveryKindOfFault) {
  const Strings none;
  EXPECT_EQ(faults_of("scene/crowd/a.cpp", "#include \"scene/pose/pose.h\"\n"), none);
  EXPECT_EQ(faults_of("scene/pose/a.cpp", "#include \"scene/crowd/crowd.h\"\n"),
            Strings{"scene/pose/a.cpp:1: includes \"scene/crowd/crowd.h\": scene/pose may not know scene/crowd"});
  EXPECT_EQ(faults_of("renderers/flat/a.cpp", "#include \"renderers/relief/relief.h\"\n").size(), 1U);
  EXPECT_EQ(faults_of("renderers/new/a.cpp", "#include \"renderers/gl/objects.h\"\n"), none);
  EXPECT_EQ(faults_of("renderers/new/a.cpp", "#include \"renderers/flat/flat.h\"\n").size(), 1U);
  EXPECT_EQ(faults_of("renderers/new/a.cpp", "#include \"renderers/mesh/mesh.h\"\n").size(), 1U);
  EXPECT_EQ(faults_of("renderers/rigid/a.cpp", "#include \"renderers/mesh/mesh.h\"\n"), none);
  EXPECT_EQ(faults_of("renderers/registry.cpp", "#include \"renderers/new/new.h\"\n"), none);
  EXPECT_EQ(faults_of("renderers/registry.cpp", "#include \"renderers/frame/capture.h\"\n").size(), 1U);
  EXPECT_EQ(faults_of("renderers/impostor/a.cpp", "#include \"renderers/new/new.h\"\n").size(), 1U);
  EXPECT_EQ(faults_of("bench/new/a.cpp", "#include \"bench/stage/coverage.h\"\n").size(), 1U);
  EXPECT_EQ(faults_of("bench/stage/a.cpp", "#include \"bench/timing/timing.h\"\n").size(), 1U);
  EXPECT_EQ(faults_of("store/a.cpp", "#include \"scene/frame/frame.h\"\n").size(), 1U);
  EXPECT_EQ(
      faults_of("scene/pose/a.cpp", "#include \"core/error.h\"\n#include \"scene/pose/b.h\"\n#include <vector>\n"),
      none);
  EXPECT_EQ(faults_of("scene/a.cpp", "\n#include \"renderers/frame/capture.h\"\n"),
            Strings{"scene/a.cpp:2: includes \"renderers/frame/capture.h\": scene may not know renderers"});
  EXPECT_EQ(faults_of("core/a.cpp", "#include \"scene/frame/frame.h\"\n").size(), 1U);
  EXPECT_EQ(faults_of("truth/a.cpp", "#include \"renderers/frame/capture.h\"\n").size(), 1U);
  EXPECT_EQ(faults_of("metrics/a.cpp", "# include \"scene/frame/frame.h\"\n").size(), 1U);
  EXPECT_EQ(faults_of("reports/a.cpp", "#include \"metrics/ssim.h\"\n").size(), 1U);
  EXPECT_EQ(faults_of("renderers/a.cpp", "#include \"studies/stimuli/clip.h\"\n").size(), 1U);
  EXPECT_EQ(faults_of("studies/a.cpp", "#include \"bench/commands/commands.h\"\n").size(), 1U);
  EXPECT_EQ(faults_of("bench/a.cpp", "#include \"reports/page/report_page.h\"\n#include \"studies/stimuli/clip.h\"\n"),
            none);
  EXPECT_EQ(faults_of("studies/stimuli/a.cpp", "#include \"renderers/frame/capture.h\"\n"), none);
  EXPECT_EQ(faults_of("studies/analysis/a.cpp", "#include \"core/error.h\"\n"), none);
  EXPECT_EQ(faults_of("studies/analysis/a.cpp", "#include \"renderers/frame/capture.h\"\n").size(), 1U);
  EXPECT_EQ(faults_of("scene/a.cpp", "#include \"frame.h\"\n").size(), 1U);
  EXPECT_EQ(faults_of("scene/a.cpp", "#include \"../renderers/capture.h\"\n").size(), 1U);
  EXPECT_EQ(faults_of("scene/a.h", "#pragma once\n#include <nlohmann/json.hpp>\n").size(), 1U);
  EXPECT_EQ(faults_of("scene/a.h", "#pragma once\n#include <nlohmann/json_fwd.hpp>\n"), none);
  EXPECT_EQ(faults_of("scene/a.h", "#include <vector>\n"), Strings{"scene/a.h:1: has no #pragma once"});
  EXPECT_EQ(faults_of("scene/a.h", "#ifndef CROWDBENCH_A_H\n").size(), 1U);
  EXPECT_EQ(faults_of("renderers/a.shared.h", "#ifndef CROWDBENCH_A_H\n#define CROWDBENCH_A_H\n"), none);
  EXPECT_EQ(faults_of("renderers/a.shared.h", "#define A 1\n").size(), 1U);
  EXPECT_EQ(faults_of("scene/a.cpp", "#include <epoxy/gl.h>\n").size(), 1U);
  EXPECT_EQ(faults_of("renderers/mesh/a.cpp", "#include <epoxy/gl.h>\n"), none);
  EXPECT_EQ(faults_of("renderers/mesh/a.cpp", "glCreateBuffers(1, &b); glDeleteBuffers (1, &b);\n").size(), 1U);
  EXPECT_EQ(faults_of("renderers/mesh/a.cpp", "glGenTextures(1, &t);\n").size(), 1U);
  EXPECT_EQ(faults_of("renderers/mesh/a.cpp", "glGenerateTextureMipmap(t);\n"), none);
  EXPECT_EQ(faults_of("renderers/gl/objects.cpp", "glCreateBuffers(1, &b);\n"), none);
  EXPECT_EQ(faults_of("scene/a.cpp", "// #include \"renderers/x.h\"\n/* \n#include \"bench/x.h\"\n*/\n"), none);
}

// ---- headers and tests

// Headers that another folder includes and no test: path, or the end of one -> why.
const std::map<std::string, std::string>& untested_headers() {
  static const std::map<std::string, std::string> all = {
      {"_api.h", "the C interface of a module, which both of its sides include and nobody else"},
      {"core/oiio/oiio.h", "the C interface of a module"},
      {"renderers/polypostor/polypostor.h", "declares the type that the registry lists"},
      {"renderers/relief/relief.h", "declares the type that the registry lists"},
  };
  return all;
}

bool ends_with_any(const std::string& path) {
  return std::ranges::any_of(untested_headers(), [&](const auto& entry) { return path.ends_with(entry.first); });
}

// includes: by file, what it includes. Headers that only their own folder includes are its own affair.
Strings headers_without_test(const std::map<std::string, Strings>& includes) {
  std::set<std::string> shared;
  std::set<std::string> tested;
  for (const auto& [file, targets] : includes)
    for (const std::string& target : targets) {
      const bool test = starts_with(file, "tests/");
      if (test)
        tested.insert(target);
      else if (fs::path(file).parent_path() != fs::path(target).parent_path())
        shared.insert(target);
    }
  Strings out;
  for (const std::string& header : shared)
    if (!tested.contains(header)) out.push_back(header);
  return out;
}

// What a file includes by its path from the repository's root, of the rooms.
Strings own_includes(const std::string& text) {
  static const std::regex include(R"re(^\s*#\s*include\s*"([^"]+\.h)")re");
  Strings out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (std::smatch match; std::regex_search(line, match, include) && doors().contains(room_of(match[1])))
      out.push_back(match[1]);
  return out;
}

TEST(Includes, AHeaderThatAnotherFolderIncludesHasATest) {
  CROWDBENCH_SKIP_SANITIZED("TheSearchForUntestedHeadersFindsThem");
  const fs::path root = CROWDBENCH_SOURCE_DIR;
  std::map<std::string, Strings> includes;
  for (const char* room :
       {"core", "store", "scene", "truth", "renderers", "metrics", "studies", "reports", "bench", "tests"})
    for (const auto& entry : fs::recursive_directory_iterator(root / room))
      if (const auto extension = entry.path().extension(); extension == ".h" || extension == ".cpp")
        includes[entry.path().lexically_relative(root).generic_string()] = own_includes(read(entry.path()));
  const Strings found = headers_without_test(includes);
  for (const std::string& header : found)
    EXPECT_TRUE(ends_with_any(header)) << header << ": another folder includes it; hold it to worked values in a test";
  for (const auto& [header, why] : untested_headers())
    EXPECT_TRUE(std::ranges::any_of(found, [end = &header](const std::string& path) { return path.ends_with(*end); }))
        << header << " is tested, or gone: take it off the list";
}

// ---- headers and the standard library

// The standard header that a name is from, where it is not called like the name. tools/check_headers.sh compiles
// headers behind a precompiled standard library, which hides a missing include; this shows it.
const std::map<std::string, std::string>& standard_headers() {
  static const std::map<std::string, std::string> all = {
      {"abs", "cmath"},
      {"aligned_alloc", "cstdlib"},
      {"atoi", "cstdlib"},
      {"bad_alloc", "new"},
      {"bit_cast", "bit"},
      {"clamp", "algorithm"},
      {"convertible_to", "concepts"},
      {"copy", "algorithm"},
      {"errc", "system_error"},
      {"floor", "cmath"},
      {"fma", "cmath"},
      {"forward", "utility"},
      {"free", "cstdlib"},
      {"from_chars", "charconv"},
      {"function", "functional"},
      {"get", "utility"},
      {"holds_alternative", "variant"},
      {"integral", "concepts"},
      {"is_arithmetic_v", "type_traits"},
      {"is_enum_v", "type_traits"},
      {"is_floating_point_v", "type_traits"},
      {"is_integral_v", "type_traits"},
      {"is_same_v", "type_traits"},
      {"is_signed_v", "type_traits"},
      {"is_standard_layout_v", "type_traits"},
      {"is_trivially_copyable_v", "type_traits"},
      {"is_trivially_destructible_v", "type_traits"},
      {"less", "functional"},
      {"log2", "cmath"},
      {"lround", "cmath"},
      {"make_shared", "memory"},
      {"max", "algorithm"},
      {"memcpy", "cstring"},
      {"min", "algorithm"},
      {"minmax", "algorithm"},
      {"monostate", "variant"},
      {"move", "utility"},
      {"nullopt", "optional"},
      {"nullptr_t", "cstddef"},
      {"numeric_limits", "limits"},
      {"pair", "utility"},
      {"pow", "cmath"},
      {"ranges", "algorithm"},
      {"runtime_error", "stdexcept"},
      {"same_as", "concepts"},
      {"shared_ptr", "memory"},
      {"swap", "utility"},
      {"swap_ranges", "algorithm"},
      {"to_string", "string"},
      {"type_index", "typeindex"},
      {"u32string", "string"},
      {"unique_ptr", "memory"},
  };
  return all;
}

// What the standard says that a header brings along, and what every implementation's does.
const std::map<std::string, Strings>& brought_along() {
  static const std::map<std::string, Strings> all = {
      {"string", {"string_view", "initializer_list", "utility"}},
      {"vector", {"initializer_list", "utility"}},
      {"map", {"initializer_list", "utility"}},
      {"set", {"initializer_list", "utility"}},
      {"array", {"utility", "tuple"}},
      {"memory", {"utility"}},
      {"optional", {"utility"}},
      {"variant", {"utility"}},
      {"functional", {"utility"}},
      {"tuple", {"utility"}},
      {"filesystem", {"string", "string_view", "utility"}},
      {"algorithm", {"utility"}},
  };
  return all;
}

// The standard names that a file's text uses, comments apart, as the headers they are from.
std::set<std::string> standard_headers_of(const std::string& text) {
  static const std::regex name(R"re(\bstd::([a-z_0-9]+))re");
  std::set<std::string> out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    line.resize(std::min(line.size(), line.find("//")));
    for (std::sregex_iterator it(line.begin(), line.end(), name), end; it != end; ++it) {
      const auto found = standard_headers().find((*it)[1]);
      out.insert(found != standard_headers().end() ? found->second : (*it)[1].str());
    }
  }
  return out;
}

// The standard headers that a file includes itself or by the product's own headers.
std::set<std::string> standard_includes(const std::string& file, const std::map<std::string, std::string>& texts) {
  static const std::regex include(R"re(^\s*#\s*include\s*<([a-z_0-9]+)>)re");
  std::set<std::string> out;
  std::set<std::string> seen;
  for (Strings open{file}; !open.empty();) {
    const std::string at = open.back();
    open.pop_back();
    const auto text = texts.find(at);
    if (text == texts.end() || !seen.insert(at).second) continue;
    for (std::string& target : own_includes(text->second)) open.push_back(std::move(target));
    std::istringstream lines(text->second);
    for (std::string line; std::getline(lines, line);)
      if (std::smatch match; std::regex_search(line, match, include)) {
        out.insert(match[1]);
        if (const auto more = brought_along().find(match[1]); more != brought_along().end())
          out.insert(more->second.begin(), more->second.end());
      }
  }
  return out;
}

Strings standard_headers_missing(const std::string& file, const std::map<std::string, std::string>& texts) {
  const std::set<std::string> given = standard_includes(file, texts);
  Strings out;
  for (const std::string& header : standard_headers_of(texts.at(file)))
    if (!given.contains(header)) out.push_back(header);
  return out;
}

TEST(Includes, AHeaderIncludesTheStandardHeadersThatItNames) {
  CROWDBENCH_SKIP_SANITIZED("AMissingStandardHeaderIsFound");
  const fs::path root = CROWDBENCH_SOURCE_DIR;
  std::map<std::string, std::string> texts;
  for (const char* room : {"core", "store", "scene", "truth", "renderers", "metrics", "studies", "reports", "bench"})
    for (const auto& entry : fs::recursive_directory_iterator(root / room))
      if (entry.path().extension() == ".h")
        texts[entry.path().lexically_relative(root).generic_string()] = read(entry.path());
  EXPECT_GT(texts.size(), 300U);
  for (const auto& entry : texts)
    for (const std::string& header : standard_headers_missing(entry.first, texts))
      ADD_FAILURE() << entry.first << ": names what is from <" << header << "> and does not include it";
}

TEST(Includes, AMissingStandardHeaderIsFound) {
  const std::map<std::string, std::string> texts = {
      {"core/a.h", "#include <vector>\nstd::vector<std::string> f();  // std::map\n"},
      {"core/b.h", "#include \"core/c.h\"\nstd::unique_ptr<std::string_view> g(std::vector<int>);\n"},
      {"core/c.h", "#include <memory>\n#include <string>\n"},
  };
  EXPECT_EQ(standard_headers_missing("core/a.h", texts), Strings{"string"});
  EXPECT_EQ(standard_headers_missing("core/b.h", texts), Strings{"vector"});
  EXPECT_EQ(standard_headers_missing("core/c.h", texts), Strings{});
}

TEST(Includes, TheSearchForUntestedHeadersFindsThem) {
  const std::string text = "#pragma once\n#include <vector>\n#include \"core/error.h\"\n#include \"test_paths.h\"\n";
  EXPECT_EQ(own_includes(text), Strings{"core/error.h"});
  std::map<std::string, Strings> includes = {{"scene/pose/a.cpp", {"scene/pose/own.h", "scene/frame/shared.h"}},
                                             {"tests/scene/a_test.cpp", {"scene/pose/own.h"}}};
  EXPECT_EQ(headers_without_test(includes), Strings{"scene/frame/shared.h"});
  includes["tests/scene/b_test.cpp"] = {"scene/frame/shared.h"};
  EXPECT_TRUE(headers_without_test(includes).empty());
}

}  // namespace
}  // namespace crowdbench
