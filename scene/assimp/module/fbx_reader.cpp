// Based on: A. Gessler (Blender Foundation), "FBX binary file format specification", 2013, for the binary form.
#include "scene/assimp/module/fbx_reader.h"

#include <zlib.h>

#include <cstdlib>
#include <cstring>
#include <string_view>

namespace crowdbench::scene::assimp_module {
namespace {

constexpr size_t kDeepestNode = 64;
constexpr uint64_t kMostBytes = uint64_t{512} << 20;  // of one list, unpacked

// --- text ---

class TextWalk {
 public:
  TextWalk(std::string_view text, FbxVisitor& visitor) : text_(text), visitor_(visitor) {}

  void run() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == ';')
        at_ = std::min(text_.find('\n', at_), text_.size());
      else if (c == '"')
        string();
      else if (c == '{')
        open();
      else if (c == '}')
        close();
      else if (is_word(c))
        word();
      else
        star_ = c == '*' || (star_ && c == ' '), ++at_;
      if (path_.size() > kDeepestNode) return;
    }
  }

 private:
  static bool is_word(char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_' || c == '-' ||
           c == '+' || c == '.';
  }
  void string() {
    const size_t end = std::min(text_.find('"', at_ + 1), text_.size());
    if (named_ && node_.strings.size() < 8) node_.strings.emplace_back(text_.substr(at_ + 1, end - at_ - 1));
    at_ = end + 1;
  }
  void word() {
    size_t end = at_;
    while (end < text_.size() && is_word(text_[end])) ++end;
    const std::string_view word = text_.substr(at_, end - at_);
    at_ = end;
    if (at_ < text_.size() && text_[at_] == ':') {
      ++at_;
      finish();
      node_.name = word;
      named_ = true;
    } else if (named_) {
      number(std::string(word));
    }
    star_ = false;
  }
  void number(const std::string& word) {
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    if (end != word.c_str() + word.size()) return;
    if (star_) {
      node_.declared = static_cast<int64_t>(value);
      return;
    }
    ++node_.count;
    if (node_.numbers.size() < 8 || visitor_.wants(node_.name == "a" && !path_.empty() ? path_.back() : node_.name))
      node_.numbers.push_back(value);
  }
  // A node without children; a list's "a" stands for the list.
  void finish() {
    if (!named_) return;
    if (node_.name == "a" && !path_.empty()) {
      node_.name = path_.back();
      node_.declared = declared_;
      const std::string list = path_.back();
      path_.pop_back();
      visitor_.begin(path_, node_);
      visitor_.end(path_, list);
      path_.push_back(list);
    } else {
      visitor_.begin(path_, node_);
      visitor_.end(path_, node_.name);
    }
    node_ = {};
    named_ = false;
  }
  void open() {
    ++at_;
    declared_ = node_.declared;
    if (declared_ < 0) visitor_.begin(path_, node_);
    lists_.push_back(declared_ >= 0);
    path_.push_back(node_.name);
    node_ = {};
    named_ = false;
  }
  void close() {
    ++at_;
    finish();
    if (path_.empty()) return;
    const std::string name = path_.back();
    path_.pop_back();
    if (!lists_.back()) visitor_.end(path_, name);
    lists_.pop_back();
  }

  std::string_view text_;
  FbxVisitor& visitor_;
  size_t at_ = 0;
  FbxNode node_;
  bool named_ = false;
  bool star_ = false;
  int64_t declared_ = -1;
  std::vector<std::string> path_;
  std::vector<bool> lists_;  // of path_: a list's braces
};

// --- binary ---

class BinaryWalk {
 public:
  BinaryWalk(std::span<const uint8_t> bytes, FbxVisitor& visitor) : bytes_(bytes), visitor_(visitor) {}

  void run() {
    at_ = 23;
    const uint64_t version = take<uint32_t>();
    wide_ = version >= 7500;
    while (!broken_ && node()) {
    }
  }

 private:
  template <typename T>
  T take() {
    T value{};
    if (broken_ || bytes_.size() - at_ < sizeof value) {
      broken_ = true;
      return value;
    }
    std::memcpy(&value, bytes_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  std::span<const uint8_t> take_bytes(uint64_t size) {
    broken_ = broken_ || size > bytes_.size() - at_;
    if (broken_) return {};
    at_ += size;
    return bytes_.subspan(at_ - size, size);
  }
  uint64_t offset() { return wide_ ? take<uint64_t>() : take<uint32_t>(); }
  static std::string text(std::span<const uint8_t> bytes) { return {bytes.begin(), bytes.end()}; }

  // False at the end of a list of nodes.
  bool node() {
    const uint64_t end = offset();
    const uint64_t properties = offset();
    offset();
    FbxNode node;
    node.name = text(take_bytes(take<uint8_t>()));
    if (broken_ || end == 0) return false;
    for (uint64_t p = 0; p < properties && !broken_; ++p) property(node);
    broken_ = broken_ || end > bytes_.size() || end < at_ || path_.size() > kDeepestNode;
    if (broken_) return false;
    visitor_.begin(path_, node);
    path_.push_back(node.name);
    while (at_ < end && this->node()) {
    }
    path_.pop_back();
    if (broken_) return false;
    visitor_.end(path_, node.name);
    at_ = end;
    return true;
  }

  void one(FbxNode& node, double value) {
    ++node.count;
    node.numbers.push_back(value);
  }
  void property(FbxNode& node) {
    const uint8_t type = take<uint8_t>();
    switch (type) {
      case 'Y': one(node, take<int16_t>()); break;
      case 'C': one(node, take<uint8_t>()); break;
      case 'I': one(node, take<int32_t>()); break;
      case 'F': one(node, static_cast<double>(take<float>())); break;
      case 'D': one(node, take<double>()); break;
      case 'L': one(node, static_cast<double>(take<int64_t>())); break;
      case 'S': node.strings.push_back(text(take_bytes(take<uint32_t>()))); break;
      case 'R': take_bytes(take<uint32_t>()); break;
      case 'f': list<float>(node); break;
      case 'd': list<double>(node); break;
      case 'l': list<int64_t>(node); break;
      case 'i': list<int32_t>(node); break;
      case 'b': list<uint8_t>(node); break;
      default: broken_ = true;
    }
  }
  template <typename T>
  void list(FbxNode& node) {
    const uint64_t count = take<uint32_t>();
    const uint32_t packed = take<uint32_t>();
    const uint64_t size = take<uint32_t>();
    const std::span<const uint8_t> data = take_bytes(packed != 0 ? size : count * sizeof(T));
    node.count += count;
    if (broken_ || !visitor_.wants(node.name) || count * sizeof(T) > kMostBytes || count == 0) return;
    std::vector<T> values(count);
    uLongf unpacked = count * sizeof(T);
    if (packed == 0)
      std::memcpy(values.data(), data.data(), data.size());
    else if (uncompress(reinterpret_cast<Bytef*>(values.data()), &unpacked, data.data(), data.size()) != Z_OK)
      return;  // Assimp's to say
    node.numbers.insert(node.numbers.end(), values.begin(),
                        values.begin() + static_cast<std::ptrdiff_t>(unpacked / sizeof(T)));
  }

  std::span<const uint8_t> bytes_;
  FbxVisitor& visitor_;
  size_t at_ = 0;
  bool wide_ = false;
  bool broken_ = false;
  std::vector<std::string> path_;
};

}  // namespace

void walk_fbx(std::span<const uint8_t> bytes, FbxVisitor& visitor) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.starts_with("Kaydara FBX Binary")) {
    if (bytes.size() > 27) BinaryWalk(bytes, visitor).run();
  } else {
    TextWalk(text, visitor).run();
  }
}

}  // namespace crowdbench::scene::assimp_module
