// Conditions on the values of a point, as plans write them: "crowd.agents * occupancy <= 500 and types != 'ten'".
//
//   condition  = conjunction {"or" conjunction}          conjunction = negation {"and" negation}
//   negation   = "not" negation | comparison             comparison  = sum [("<" "<=" ">" ">=" "==" "!=") sum]
//   sum        = product {("+" | "-") product}           product     = sign {("*" | "/") sign}
//   sign       = "-" sign | number | 'text' | axis | "(" condition ")"
//
// Texts compare by == and != alone. There is nothing else: no functions, no assignment.
#pragma once
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <variant>
#include <vector>

namespace crowdbench::bench::sweep {

// What a point has on an axis.
using AxisNumberOrText = std::variant<double, std::string>;

class Expression {
 public:
  // axes: the names that it may use. Throws Error naming `where`: not an expression, an unknown axis with the nearest,
  // longer than 1024 bytes, brackets deeper than 32.
  Expression(const std::string& text, const std::string& where, const std::vector<std::string>& axes);
  Expression(Expression&&) noexcept;
  ~Expression();

  struct Node;
  const std::set<std::string>& names() const { return names_; }
  // values: every one of names(). Throws Error where a text meets arithmetic or an order, or it gives no truth.
  template <typename Values>
  bool holds(const Values& values) const {
    return holds_of([&](const std::string& name) -> AxisNumberOrText { return values.at(name); });
  }

 private:
  bool holds_of(const std::function<AxisNumberOrText(const std::string&)>& value_of) const;

  std::string text_, where_;
  std::set<std::string> names_;
  std::unique_ptr<Node> root_;
};

}  // namespace crowdbench::bench::sweep
