// Outside its folder nobody spells a representation's name: what is needed is asked of its type. A name is found in the
// string literals of every source. The rule:
//   - Any word of a literal that is a name counts. "mesh" is also what the field calls the thing itself, and so it
//     counts only as a specification: alone, in brackets, or before ':', '(' or ',' without a space.
//   - Lines of examples ("crowdbench ...", in help) are documentation: they may name representations, and each
//     specification in them must parse.
//   - kExceptions: where a word is another thing's name. Each must still be needed.
// Comments and includes are not literals. Tests may name what they test.
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

#include "core/error.h"
#include "renderers/representation.h"
#include "test_paths.h"
#include "tests/support/sanitized.h"

namespace crowdbench::renderers {
namespace {

namespace fs = std::filesystem;
using Strings = std::vector<std::string>;

struct Exception {
  std::string path;  // below the repository: a file, or a folder that ends in '/'
  std::string name;
  std::string reason;
};
const std::vector<Exception>& exceptions() {
  static const std::vector<Exception> all = {
      {"scene/gltf/", "mesh", "a key of glTF files"},
      {"scene/assimp/module/", "mesh", "a key of glTF files"},
      {"scene/gltf/gltf_load.cpp", "flat", "flat normals, glTF's word"},
      {"scene/gltf/gltf_check_nodes.cpp", "rigid", "meshes that hang on a joint without a skin"},
      {"renderers/relief/relief.cpp", "rigid", "boxes that do not bend, its source's form"},
      {"bench/commands/inspect.cpp", "mesh", "bytes of a character's mesh"},
      {"bench/commands/inspect.cpp", "rigid", "meshes that hang on a joint without a skin"},
  };
  return all;
}

// The string literals of a source, comments and includes left out, neighbours joined as the compiler joins them.
// Escapes stay as they are written.
Strings literals_of(const std::string& text) {
  Strings out;
  bool joined = false;  // nothing but space since the last literal
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '/' && i + 1 < text.size() && text[i + 1] == '/') {
      while (i < text.size() && text[i] != '\n') ++i;
    } else if (c == '/' && i + 1 < text.size() && text[i + 1] == '*') {
      i = std::min(text.find("*/", i), text.size() - 1) + 1;
    } else if (c == '#' && text.compare(i, 8, "#include") == 0) {
      while (i < text.size() && text[i] != '\n') ++i;
    } else if (c == '\'' && i > 0 && std::isalnum(static_cast<unsigned char>(text[i - 1])) != 0) {
      joined = false;  // 1'000
    } else if (c == '\'') {
      for (++i; i < text.size() && text[i] != '\''; ++i)
        if (text[i] == '\\') ++i;
      joined = false;
    } else if (c == '"') {
      std::string literal;
      for (++i; i < text.size() && text[i] != '"'; ++i) {
        if (text[i] == '\\') literal += text[i++];
        literal += text[i];
      }
      if (joined)
        out.back() += literal;
      else
        out.push_back(literal);
      joined = true;
    } else if (std::isspace(static_cast<unsigned char>(c)) == 0) {
      joined = false;
    }
  }
  return out;
}

Strings lines_of(const std::string& literal) {
  Strings lines{""};
  for (size_t i = 0; i < literal.size(); ++i) {
    if (literal[i] == '\\' && i + 1 < literal.size() && literal[i + 1] == 'n') {
      lines.emplace_back();
      ++i;
    } else {
      lines.back() += literal[i];
    }
  }
  return lines;
}

bool is_example(const std::string& line) {
  const size_t first = line.find_first_not_of(' ');
  return first != std::string::npos && line.compare(first, 11, "crowdbench ") == 0;
}

// Names that a literal spells, its examples left out.
std::set<std::string> names_in(const std::string& literal, const Strings& names) {
  std::set<std::string> found;
  for (const std::string& line : lines_of(literal)) {
    if (is_example(line)) continue;
    for (const std::string& name : names) {
      if (line.find(name) == std::string::npos) continue;
      const std::string pattern =
          name == "mesh" ? R"(^mesh($|[:(,]\w)|[ '(,]mesh[:(]\w|[(,]mesh[,)])" : "\\b" + name + "\\b";
      if (std::regex_search(line, std::regex(pattern))) found.insert(name);
    }
  }
  return found;
}

std::string read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

struct Source {
  std::string path;
  Strings literals;
};
const std::vector<Source>& sources() {
  static const std::vector<Source> all = [] {
    const fs::path root = CROWDBENCH_SOURCE_DIR;
    std::vector<Source> out;
    for (const char* room : {"core", "store", "scene", "truth", "renderers", "metrics", "studies", "bench", "reports"})
      for (const auto& entry : fs::recursive_directory_iterator(root / room)) {
        const std::string extension = entry.path().extension().string();
        if (extension == ".h" || extension == ".cpp")
          out.push_back({entry.path().lexically_relative(root).generic_string(), literals_of(read(entry.path()))});
      }
    return out;
  }();
  return all;
}

Strings all_names() {
  Strings names;
  for (const RepresentationType& type : representation_types()) names.push_back(type.name);
  return names;
}

TEST(RepresentationNames, NobodyOutsideItsFolderSpellsOne) {
  CROWDBENCH_SKIP_SANITIZED("nothing: it reads sources");
  const Strings names = all_names();
  ASSERT_GE(names.size(), 6U);
  ASSERT_GT(sources().size(), 200U) << "the walk found the tree";
  std::vector<bool> needed(exceptions().size());
  size_t own = 0;  // names spelt in their own folder: the search finds what there is to find
  for (const Source& source : sources())
    for (const std::string& literal : source.literals)
      for (const std::string& name : names_in(literal, names)) {
        if (source.path.rfind("renderers/" + name + "/", 0) == 0) {
          ++own;
          continue;
        }
        const auto excused = std::find_if(exceptions().begin(), exceptions().end(), [&](const Exception& e) {
          return e.name == name && (e.path.back() == '/' ? source.path.rfind(e.path, 0) == 0 : source.path == e.path);
        });
        if (excused != exceptions().end()) {
          needed[static_cast<size_t>(excused - exceptions().begin())] = true;
          continue;
        }
        ADD_FAILURE() << source.path << " spells '" << name << "': \"" << literal << "\"";
      }
  EXPECT_GE(own, names.size());
  for (size_t i = 0; i < needed.size(); ++i)
    EXPECT_TRUE(needed[i]) << exceptions()[i].path << " no longer needs its exception for '" << exceptions()[i].name
                           << "'";
}

// The words behind these options in every example of the help.
TEST(RepresentationNames, ExamplesOfTheHelpParse) {
  const std::regex given(R"re((?:--representations?|-r|--of|--to|--a|--b) '?([^ \\"']+))re");
  size_t parsed = 0;
  for (const Source& source : sources())
    for (const std::string& literal : source.literals)
      for (const std::string& line : lines_of(literal)) {
        // `info --representations` takes none.
        if (!is_example(line) || line.find("crowdbench info") != std::string::npos) continue;
        for (auto match = std::sregex_iterator(line.begin(), line.end(), given); match != std::sregex_iterator();
             ++match) {
          // A comma separates specifications where no option could follow it.
          const std::string text = (*match)[1];
          std::istringstream words(text);
          std::string word;
          const bool list = text.find_first_of(":(") == std::string::npos;
          while (list ? static_cast<bool>(std::getline(words, word, ',')) : word.empty()) {
            if (!list) word = text;
            ++parsed;
            EXPECT_NO_THROW((void)parse_spec(word)) << source.path << ": " << line;
          }
        }
      }
  EXPECT_GT(parsed, 10U);
}

TEST(RepresentationNames, TheSearchFindsEveryKindOfSpelling) {
  const Strings names = {"mesh", "flat"};
  using Found = std::set<std::string>;
  EXPECT_EQ(literals_of("a(\"x\" /* \"no\" */ \"y\"); // \"no\"\n#include \"flat.h\"\nb('\"', 1'000, \"z\\\"\")"),
            (Strings{"xy", "z\\\""}));
  EXPECT_EQ(names_in("mesh", names), Found{"mesh"});
  EXPECT_EQ(names_in("mesh:floor=1", names), Found{"mesh"});
  EXPECT_EQ(names_in("hybrid(mesh,flat)", names), (Found{"flat", "mesh"}));
  EXPECT_EQ(names_in("the mesh takes {} times", names), Found{});
  EXPECT_EQ(names_in("mesh, own pose", names), Found{});
  EXPECT_EQ(names_in("(solved with the mesh), one tick", names), Found{});
  EXPECT_EQ(names_in("write (mesh,FAR)", names), Found{"mesh"});
  EXPECT_EQ(names_in("what is switched to (flat)", names), Found{"flat"});
  EXPECT_EQ(names_in("flatter", names), Found{});
  EXPECT_EQ(names_in("Examples:\\n  crowdbench bake flat\\nand flat too", names), Found{"flat"});
  EXPECT_EQ(names_in("Examples:\\n  crowdbench bake flat --json", names), Found{});
}

}  // namespace
}  // namespace crowdbench::renderers
