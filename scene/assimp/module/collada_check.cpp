#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "scene/assimp/module/conversion.h"
#include "scene/assimp/module/source_check.h"

namespace crowdbench::scene::assimp_module {
namespace {

constexpr size_t kDeepestTag = 256;
constexpr double kMostSeconds = 1e6;

using Attributes = std::map<std::string, std::string, std::less<>>;

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

std::string_view next_word(std::string_view& text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  size_t end = 0;
  while (end < text.size() && !is_space(text[end])) ++end;
  const std::string_view word = text.substr(0, end);
  text.remove_prefix(end);
  return word.size() > 1 && word.front() == '+' ? word.substr(1) : word;
}

uint64_t count_words(std::string_view text) {
  uint64_t count = 0;
  while (!next_word(text).empty()) ++count;
  return count;
}

struct ColladaSource {
  uint64_t values = 0;
  bool has_array = false;
  std::string_view content;
  uint64_t elements = 0;
};

struct ColladaInput {
  std::string semantic;
  std::string source;
  uint64_t offset = 0;
};

// One of triangles, polylist, polygons ..., or vertex_weights.
struct ColladaPrimitive {
  std::string kind;
  uint64_t count = 0;
  std::vector<ColladaInput> inputs;
  std::vector<uint64_t> sizes;          // vcount
  std::vector<std::string_view> lists;  // p or v, in order
};

class ColladaChecks {
 public:
  void begin(std::string_view tag, const Attributes& with) {
    path_.emplace_back(tag);
    attributes_.push_back(with);
    if (tag == "geometry") {
      owner_ = "mesh " + shown(named(with));
      sources_.clear();
    } else if (tag == "controller") {
      owner_ = "skin " + shown(named(with));
      sources_.clear();
    } else if (tag == "animation") {
      owner_ = "animation " + shown(named(with));
    } else if (tag == "source") {
      source_ = of(with, "id");
      sources_[source_] = {};
    } else if (tag == "accessor" && !source_.empty()) {
      accessor(with);
    } else if (tag == "param" && of(with, "name") == "TIME" && !source_.empty()) {
      times();
    } else if (tag == "input") {
      input(with);
    } else if (is_primitive(tag)) {
      primitive_ = {};
      primitive_.kind = tag;
      primitive_.count = number(with, "count", 0);
    }
  }

  void text(std::string_view content) {
    if (path_.empty()) return;
    const std::string& tag = path_.back();
    if (tag.ends_with("_array")) array(content);
    if (path_.size() < 2 || !is_primitive(path_[path_.size() - 2])) return;
    if (tag == "vcount") sizes(content);
    if (tag == "p" || tag == "v") primitive_.lists.push_back(content);
  }

  void end() {
    if (path_.empty()) return;
    const std::string tag = path_.back();
    path_.pop_back();
    attributes_.pop_back();
    if (tag == "source") source_.clear();
    if (is_primitive(tag)) check_primitive();
  }

  size_t depth() const { return path_.size(); }

 private:
  static std::string of(const Attributes& with, std::string_view key) {
    const auto found = with.find(key);
    return found == with.end() ? std::string() : found->second;
  }
  static std::string named(const Attributes& with) {
    const std::string name = of(with, "name");
    return name.empty() ? of(with, "id") : name;
  }
  static std::string target(const Attributes& with) {
    const std::string url = of(with, "source");
    return url.starts_with('#') ? url.substr(1) : url;
  }
  static bool is_primitive(std::string_view tag) {
    return tag == "triangles" || tag == "polylist" || tag == "polygons" || tag == "vertex_weights";
  }
  uint64_t number(const Attributes& with, std::string_view key, uint64_t otherwise) const {
    const std::string text = of(with, key);
    if (text.empty()) return otherwise;
    uint64_t value = 0;
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (fault != std::errc{} || end != text.data() + text.size())
      throw Refusal{fmt::format("{}: {}=\"{}\" of {} is not a number", owner_, key, shown(text), path_.back())};
    return value;
  }

  void array(std::string_view content) {
    const uint64_t says = number(attributes_.back(), "count", 0);
    const uint64_t holds = count_words(content);
    if (says != holds)
      throw Refusal{fmt::format("{}: {} {} says {} values and holds {}", owner_, path_.back(),
                                shown(of(attributes_.back(), "id")), says, holds)};
    sources_[source_].values = holds;
    sources_[source_].has_array = true;
    sources_[source_].content = content;
  }

  void accessor(const Attributes& with) {
    ColladaSource& source = sources_[source_];
    const uint64_t count = number(with, "count", 0);
    const uint64_t stride = number(with, "stride", 1);
    const uint64_t offset = number(with, "offset", 0);
    source.elements = count;
    if (!source.has_array) return;
    if (stride == 0) throw Refusal{fmt::format("{}: the accessor of {} has stride 0", owner_, shown(source_))};
    if (count > 0 && (offset > source.values || count > (source.values - offset) / stride))
      throw Refusal{fmt::format("{}: the accessor of {} takes {} elements of {} from {} values", owner_, shown(source_),
                                count, stride, source.values - std::min(offset, source.values))};
  }

  void times() const {
    std::string_view content = sources_.at(source_).content;
    double last = -kMostSeconds;
    size_t at = 0;
    for (std::string_view word = next_word(content); !word.empty(); word = next_word(content), ++at) {
      double time = 0;
      const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), time);
      if (fault != std::errc{} || !(std::abs(time) <= kMostSeconds))
        throw Refusal{fmt::format("{}: key time {} of {} is {}, not a number of seconds up to {}", owner_, at,
                                  shown(source_), shown(std::string(word)), kMostSeconds)};
      if (time < last)
        throw Refusal{fmt::format("{}: key time {} of {} lies before the one in front", owner_, at, shown(source_))};
      last = time;
    }
  }

  void input(const Attributes& with) {
    if (path_.size() < 2) return;
    const std::string& parent = path_[path_.size() - 2];
    const std::string semantic = of(with, "semantic");
    if (parent == "vertices" && semantic == "POSITION")
      positions_[of(attributes_[path_.size() - 2], "id")] = target(with);
    if (is_primitive(parent)) primitive_.inputs.push_back({semantic, target(with), number(with, "offset", 0)});
  }

  void sizes(std::string_view content) {
    for (std::string_view word = next_word(content); !word.empty(); word = next_word(content))
      primitive_.sizes.push_back(static_cast<uint64_t>(std::max<int64_t>(integer(word, primitive_.sizes.size()), 0)));
    if (primitive_.sizes.size() != primitive_.count)
      throw Refusal{fmt::format("{}: <vcount> has {} numbers for the {} of {}", owner_, primitive_.sizes.size(),
                                primitive_.count, primitive_.kind)};
  }

  int64_t integer(std::string_view word, size_t at) const {
    int64_t value = 0;
    const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (fault != std::errc{} || end != word.data() + word.size())
      throw Refusal{fmt::format("{}: number {} of <{}> is '{}'", owner_, at, path_.back(), shown(std::string(word)))};
    return value;
  }

  // How many elements an input has; false where it is none of these sources (Assimp says that it is not there).
  bool elements_of(const ColladaInput& input, std::string& source, uint64_t& count) const {
    source = input.source;
    if (input.semantic == "VERTEX") {
      const auto vertices = positions_.find(input.source);
      if (vertices == positions_.end()) return false;
      source = vertices->second;
    }
    const auto found = sources_.find(source);
    if (found == sources_.end()) return false;
    count = found->second.elements;
    return true;
  }

  void check_primitive() {
    const bool weights = primitive_.kind == "vertex_weights";
    const char* list = weights ? "v" : "p";
    uint64_t stride = 0;
    for (const ColladaInput& input : primitive_.inputs) stride = std::max(stride, input.offset + 1);
    if (stride == 0) return;
    if (stride > 64)
      throw Refusal{fmt::format("{}: {} has inputs up to offset {}", owner_, primitive_.kind, stride - 1)};
    std::vector<std::vector<const ColladaInput*>> columns(stride);
    for (const ColladaInput& input : primitive_.inputs) columns[input.offset].push_back(&input);
    uint64_t held = 0;
    path_.emplace_back(list);  // for what is said
    for (std::string_view content : primitive_.lists)
      for (std::string_view word = next_word(content); !word.empty(); word = next_word(content)) {
        check_index(integer(word, held), held, columns[held % stride], list);
        ++held;
      }
    path_.pop_back();
    uint64_t corners = 3 * primitive_.count;
    if (!primitive_.sizes.empty()) {
      corners = 0;
      for (const uint64_t size : primitive_.sizes) corners += std::min<uint64_t>(size, uint64_t{1} << 32);
    } else if (primitive_.kind != "triangles") {
      return;
    }
    if (held != corners * stride)
      throw Refusal{fmt::format("{}: <{}> of {} holds {} indices, and {} corners take {}", owner_, list,
                                primitive_.kind, held, corners, corners * stride)};
  }

  void check_index(int64_t index, uint64_t at, const std::vector<const ColladaInput*>& inputs, const char* list) const {
    for (const ColladaInput* input : inputs) {
      std::string source;
      uint64_t count = 0;
      if (!elements_of(*input, source, count)) continue;
      if (index < 0 || static_cast<uint64_t>(index) >= count)
        throw Refusal{fmt::format("{}: index {} of <{}> of {} names {} {} of the {} in {}", owner_, at, list,
                                  primitive_.kind, input->semantic, index, count, shown(source))};
    }
  }

  std::vector<std::string> path_;
  std::vector<Attributes> attributes_;
  std::string owner_ = "the document";
  std::string source_;
  std::map<std::string, ColladaSource> sources_;  // of the present geometry or controller
  std::map<std::string, std::string> positions_;  // by <vertices>
  ColladaPrimitive primitive_;
};

// Tags, attributes and text, as far as they can be followed.
class XmlWalk {
 public:
  XmlWalk(std::string_view text, ColladaChecks& checks) : text_(text), checks_(checks) {}

  void run() {
    while (at_ < text_.size() && checks_.depth() < kDeepestTag) {
      const size_t open = text_.find('<', at_);
      if (open == std::string_view::npos) return;
      if (fresh_) checks_.text(text_.substr(at_, open - at_));
      fresh_ = false;
      at_ = open;
      const std::string_view rest = text_.substr(at_);
      if (rest.starts_with("<!--"))
        skip("-->");
      else if (rest.starts_with("<!") || rest.starts_with("<?"))
        skip(">");
      else if (rest.starts_with("</"))
        skip(">"), checks_.end();
      else
        tag();
    }
  }

 private:
  void skip(std::string_view to) {
    const size_t end = text_.find(to, at_);
    at_ = end == std::string_view::npos ? text_.size() : end + to.size();
  }
  void tag() {
    size_t end = ++at_;
    while (end < text_.size() && !is_space(text_[end]) && text_[end] != '>' && text_[end] != '/') ++end;
    const std::string_view name = text_.substr(at_, end - at_);
    at_ = end;
    Attributes with;
    while (at_ < text_.size() && text_[at_] != '>' && text_[at_] != '/') attribute(with);
    const bool empty = at_ < text_.size() && text_[at_] == '/';
    skip(">");
    checks_.begin(name, with);
    if (empty) checks_.end();
    fresh_ = !empty;
  }
  void attribute(Attributes& with) {
    if (is_space(text_[at_])) {
      ++at_;
      return;
    }
    const size_t start = at_;
    while (at_ < text_.size() && text_[at_] != '=' && text_[at_] != '>' && !is_space(text_[at_])) ++at_;
    const std::string_view key = text_.substr(start, at_ - start);
    while (at_ < text_.size() && text_[at_] != '"' && text_[at_] != '\'' && text_[at_] != '>') ++at_;
    if (at_ >= text_.size() || text_[at_] == '>') return;
    const char quote = text_[at_++];
    const size_t end = std::min(text_.find(quote, at_), text_.size());
    with.emplace(key, text_.substr(at_, end - at_));
    at_ = std::min(end + 1, text_.size());
  }

  std::string_view text_;
  ColladaChecks& checks_;
  size_t at_ = 0;
  bool fresh_ = false;  // right behind an opening tag
};

}  // namespace

void check_collada(std::string_view text) {
  ColladaChecks checks;
  XmlWalk(text, checks).run();
}

}  // namespace crowdbench::scene::assimp_module
