#include "bench/sweep/expression.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <functional>

#include "core/error.h"

namespace crowdbench::bench::sweep {
namespace {

constexpr size_t kExpressionBytes = 1024;
constexpr int kExpressionDepth = 32;

using Truth = bool;
using Result = std::variant<Truth, double, std::string>;

}  // namespace

struct Expression::Node {
  std::string op;  // of `left` and `right`; "number", "text" and "axis" have neither, "not" and "neg" no right
  double number = 0;
  std::string text;
  std::unique_ptr<Node> left, right;
};

namespace {

using Node = Expression::Node;
using NodePtr = std::unique_ptr<Node>;

NodePtr join(const std::string& op, NodePtr left, NodePtr right) {
  auto node = std::make_unique<Node>();
  node->op = op;
  node->left = std::move(left);
  node->right = std::move(right);
  return node;
}

bool is_name_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '.';
}

class ExpressionParser {
 public:
  ExpressionParser(const std::string& text, const std::string& where, const std::vector<std::string>& axes)
      : text_(text), where_(where), axes_(axes) {}

  NodePtr run(std::set<std::string>& names) {
    names_ = &names;
    NodePtr all = condition();
    if (!word().empty()) fail(fmt::format("`{}` is not expected there", printable(word(), 40)));
    return all;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(where_, fmt::format("`{}`: {}", printable(text_, 100), what),
                "write it like \"crowd.agents * occupancy <= 500 and types != 'ten'\"");
  }

  // The next word without taking it: a name or number, a text with its quotes, an operator; empty at the end.
  std::string word() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
    if (at_ == text_.size()) return {};
    const char c = text_[at_];
    if (c == '\'' || c == '"') {
      const size_t end = text_.find(c, at_ + 1);
      if (end == std::string::npos) fail("a text has no end");
      return text_.substr(at_, end + 1 - at_);
    }
    if (is_name_character(c)) {
      size_t end = at_;
      while (end < text_.size() &&
             (is_name_character(text_[end]) || ((text_[end] == '-' || text_[end] == '+') && is_exponent(end))))
        ++end;
      return text_.substr(at_, end - at_);
    }
    for (const char* two : {"<=", ">=", "==", "!="})
      if (text_.compare(at_, 2, two) == 0) return two;
    return std::string(1, c);
  }
  // Whether the sign at `end` belongs to a number like 1e-3.
  bool is_exponent(size_t end) const {
    return end > at_ && (text_[end - 1] == 'e' || text_[end - 1] == 'E') && text_[at_] >= '0' && text_[at_] <= '9';
  }
  bool take(const std::string& wanted) {
    if (word() != wanted) return false;
    at_ += wanted.size();
    return true;
  }

  NodePtr condition() {
    NodePtr left = conjunction();
    while (take("or")) left = join("or", std::move(left), conjunction());
    return left;
  }
  NodePtr conjunction() {
    NodePtr left = negation();
    while (take("and")) left = join("and", std::move(left), negation());
    return left;
  }
  NodePtr negation() {
    if (!take("not")) return comparison();
    const Deeper deeper(*this);
    return join("not", negation(), nullptr);
  }
  NodePtr comparison() {
    NodePtr left = sum();
    for (const char* op : {"<=", ">=", "==", "!=", "<", ">"})
      if (take(op)) return join(op, std::move(left), sum());
    if (word() == "=") fail("equality is written ==");
    return left;
  }
  NodePtr sum() {
    NodePtr left = product();
    for (std::string op = word(); op == "+" || op == "-"; op = word()) {
      take(op);
      left = join(op, std::move(left), product());
    }
    return left;
  }
  NodePtr product() {
    NodePtr left = sign();
    for (std::string op = word(); op == "*" || op == "/"; op = word()) {
      take(op);
      left = join(op, std::move(left), sign());
    }
    return left;
  }
  NodePtr sign() {
    const Deeper deeper(*this);
    if (take("-")) return join("neg", sign(), nullptr);
    if (take("(")) {
      NodePtr inner = condition();
      if (!take(")")) fail("a bracket has no end");
      return inner;
    }
    return atom();
  }
  NodePtr atom() {
    const std::string found = word();
    if (found.empty()) fail("it ends too early");
    auto node = std::make_unique<Node>();
    if (found[0] == '\'' || found[0] == '"') {
      node->op = "text";
      node->text = found.substr(1, found.size() - 2);
    } else if ((found[0] >= '0' && found[0] <= '9') || found[0] == '.') {
      node->op = "number";
      const auto [end, error] = std::from_chars(found.data(), found.data() + found.size(), node->number);
      if (error != std::errc() || end != found.data() + found.size())
        fail(fmt::format("`{}` is not a number", printable(found, 40)));
    } else if (is_name_character(found[0])) {
      node->op = "axis";
      node->text = found;
      if (std::find(axes_.begin(), axes_.end(), found) == axes_.end()) {
        const std::string near = nearest_name(found, axes_);
        throw Error(where_, fmt::format("`{}` names `{}`, which is not an axis", printable(text_, 100), found),
                    near.empty() ? "name one of the plan's axes" : fmt::format("did you mean `{}`?", near));
      }
      names_->insert(found);
    } else {
      fail(fmt::format("`{}` is not expected there", printable(found, 40)));
    }
    at_ += found.size();
    return node;
  }

  struct Deeper {
    explicit Deeper(ExpressionParser& parser_) : parser(parser_) {
      if (++parser.depth_ > kExpressionDepth) parser.fail("it nests too deeply");
    }
    ~Deeper() { --parser.depth_; }
    Deeper(const Deeper&) = delete;
    Deeper& operator=(const Deeper&) = delete;
    ExpressionParser& parser;
  };

  const std::string& text_;
  const std::string& where_;
  const std::vector<std::string>& axes_;
  std::set<std::string>* names_ = nullptr;
  size_t at_ = 0;
  int depth_ = 0;
};

class Evaluation {
 public:
  Evaluation(std::string where, const std::function<AxisNumberOrText(const std::string&)>& value_of)
      : where_(std::move(where)), value_of_(value_of) {}

  Result of(const Node& node) const {
    if (node.op == "number") return node.number;
    if (node.op == "text") return node.text;
    if (node.op == "axis") {
      AxisNumberOrText value = value_of_(node.text);
      if (auto* number = std::get_if<double>(&value)) return *number;
      return std::get<std::string>(std::move(value));
    }
    if (node.op == "not") return !truth(*node.left);
    if (node.op == "and") return truth(*node.left) && truth(*node.right);
    if (node.op == "or") return truth(*node.left) || truth(*node.right);
    if (node.op == "==" || node.op == "!=") return (of(*node.left) == of(*node.right)) == (node.op == "==");
    return arithmetic(node);
  }
  bool truth(const Node& node) const {
    const Result result = of(node);
    if (const bool* found = std::get_if<bool>(&result)) return *found;
    throw Error(where_, "a number or a text stands where a comparison is wanted", "compare it: a < b");
  }

 private:
  Result arithmetic(const Node& node) const {
    const double left = number(*node.left);
    if (node.op == "neg") return -left;
    const double right = number(*node.right);
    switch (node.op[0]) {
      case '+': return left + right;
      case '-': return left - right;
      case '*': return left * right;
      case '/': return left / right;
      case '<': return node.op == "<" ? left < right : left <= right;
      default: return node.op == ">" ? left > right : left >= right;
    }
  }
  double number(const Node& node) const {
    const Result result = of(node);
    if (const double* found = std::get_if<double>(&result)) return *found;
    const auto* text = std::get_if<std::string>(&result);
    throw Error(where_,
                fmt::format("{} is not a number", text != nullptr ? "'" + printable(*text, 60) + "'" : "a truth"),
                "compare texts by == or !=");
  }

  std::string where_;
  const std::function<AxisNumberOrText(const std::string&)>& value_of_;
};

}  // namespace

Expression::Expression(const std::string& text, const std::string& where, const std::vector<std::string>& axes)
    : text_(text), where_(where) {
  if (text.size() > kExpressionBytes)
    throw Error(where, fmt::format("a condition of {} bytes", text.size()), "make several of it");
  root_ = ExpressionParser(text_, where_, axes).run(names_);
}
Expression::Expression(Expression&&) noexcept = default;
Expression::~Expression() = default;

bool Expression::holds_of(const std::function<AxisNumberOrText(const std::string&)>& value_of) const {
  return Evaluation(fmt::format("{}: `{}`", where_, printable(text_, 100)), value_of).truth(*root_);
}

}  // namespace crowdbench::bench::sweep
