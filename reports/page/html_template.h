// HTML files with places to fill, so that a page's markup is read and edited as HTML (reports/page/*.html).
//
// A subset of Mustache:
//   {{name}}                  the value `name`: text is escaped, Html stands as it is
//   {{#name}} ... {{/name}}   once for each row of a list, with the row's values; or once where a condition holds
//   {{^name}} ... {{/name}}   where the list has no row, or the condition does not hold
// A tag of a section that stands alone on its line takes the line away with it. Inside a list, a name is looked for in
// the row, then in what is around it.
//
// Differs from Mustache: a name without a value and a value that no place uses are mistakes, not empty text.
#pragma once
#include <concepts>
#include <functional>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace crowdbench::reports {

// Text that is HTML already and stands on the page as it is.
struct Html {
  std::string text;
};

class TemplateValues;
// What a name in a template stands for: text, ready HTML, a list of rows, or a condition.
class TemplateValue {
 public:
  TemplateValue(std::string text);
  TemplateValue(const char* text);
  TemplateValue(Html html);
  TemplateValue(std::vector<TemplateValues> rows);
  template <std::same_as<bool> Condition>  // not what merely converts to bool
  TemplateValue(Condition holds) : value_(holds) {}
  template <std::integral Count>
  requires(!std::same_as<Count, bool>) TemplateValue(Count count) : value_(std::to_string(count)) {}

 private:
  friend class TemplateFiller;
  std::variant<std::string, Html, bool, std::vector<TemplateValues>> value_;
};

// Values by name.
class TemplateValues {
 public:
  TemplateValues() = default;
  TemplateValues(std::initializer_list<std::pair<const std::string, TemplateValue>> values) : values_(values) {}
  TemplateValue& operator[](const std::string& name) { return values_.try_emplace(name, "").first->second; }

 private:
  friend class TemplateFiller;
  std::map<std::string, TemplateValue, std::less<>> values_;
};

// Fills `html`. A name without a value, a value without a place, a value of the wrong kind and a section that does not
// end are bugs of the program's and throw std::logic_error that names them, in every build: a page with a hole in it
// would look whole.
Html fill_template(std::string_view html, const TemplateValues& values);

}  // namespace crowdbench::reports
