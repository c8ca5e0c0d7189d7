// The rooms and which way their doors open: every include of the tree is held to the arrows.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace crowdbench {
namespace {
namespace fs = std::filesystem;

using Strings = std::vector<std::string>;

// room -> the rooms that it may include besides itself.
const std::map<std::string, std::set<std::string>>& doors() {
  static const std::map<std::string, std::set<std::string>> all = {
      {"core", {}},
      {"scene", {"core"}},
      {"renderers", {"core", "scene"}},
      {"metrics", {"core"}},
      {"studies", {"core", "scene", "renderers", "metrics"}},
      {"reports", {"core"}},
      {"bench", {"core", "scene", "renderers", "metrics", "studies", "reports"}},
  };
  return all;
}

// Libraries whose headers are slow to compile or drag a platform in: in sources only.
const Strings kHeavy = {"nlohmann/json.hpp", "CLI/",         "tiny_gltf.h", "toml.hpp", "OpenImageIO/",
                        "libavcodec/",       "libavformat/", "GLFW/",       "EGL/",     "sqlite3.h"};

std::string room_of(const std::string& path) { return path.substr(0, path.find('/')); }
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
  EXPECT_EQ(rooms, 7U);
  EXPECT_GT(files, 40U);  // the walk found the tree
}

// The checker itself: each of its faults, on made-up files.
TEST(Includes, CheckerFindsEveryKindOfFault) {
  const Strings none;
  EXPECT_EQ(faults_of("scene/a.cpp", "#include \"core/error.h\"\n#include \"scene/b.h\"\n#include <vector>\n"), none);
  EXPECT_EQ(faults_of("scene/a.cpp", "\n#include \"renderers/capture.h\"\n"),
            Strings{"scene/a.cpp:2: includes \"renderers/capture.h\": scene may not know renderers"});
  EXPECT_EQ(faults_of("core/a.cpp", "#include \"scene/frame.h\"\n").size(), 1U);
  EXPECT_EQ(faults_of("metrics/a.cpp", "# include \"scene/frame.h\"\n").size(), 1U);
  EXPECT_EQ(faults_of("reports/a.cpp", "#include \"metrics/ssim.h\"\n").size(), 1U);
  EXPECT_EQ(faults_of("renderers/a.cpp", "#include \"studies/clip.h\"\n").size(), 1U);
  EXPECT_EQ(faults_of("studies/a.cpp", "#include \"bench/commands.h\"\n").size(), 1U);
  EXPECT_EQ(faults_of("bench/a.cpp", "#include \"reports/page.h\"\n#include \"studies/clip.h\"\n"), none);
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

}  // namespace
}  // namespace crowdbench
