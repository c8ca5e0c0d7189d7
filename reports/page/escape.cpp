#include "reports/page/escape.h"

namespace crowdbench::reports {

std::string html_escape(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      case '\'': out += "&#39;"; break;
      default: out += c;
    }
  }
  return out;
}

std::string script_json(std::string_view json) {
  std::string out;
  out.reserve(json.size());
  for (const char c : json) {
    if (c == '<')
      out += "\\u003c";
    else
      out += c;
  }
  return out;
}

std::string inline_script(std::string_view script) {
  std::string text;
  text.reserve(script.size() + 64);
  for (size_t i = 0; i < script.size(); ++i) {
    const std::string_view rest = script.substr(i);
    if (rest.starts_with("\n//# sourceMappingURL=")) {
      const size_t end = rest.find('\n', 1);
      i += (end == std::string_view::npos ? rest.size() : end) - 1;
      continue;
    }
    // Both can only stand in strings and regular expressions of a valid script, where a backslash changes nothing.
    const bool tag = rest.size() >= 8 && rest[0] == '<' && rest[1] == '/' &&
                     (rest.substr(2, 6) == "script" || rest.substr(2, 6) == "SCRIPT" || rest.substr(2, 6) == "Script");
    if (tag) {
      text += "<\\/";
      ++i;
    } else if (rest.starts_with("<!--")) {
      text += "<\\!--";
      i += 3;
    } else {
      text += script[i];
    }
  }
  return text;
}

std::string comment_text(std::string_view text) {
  std::string out(text);
  for (size_t at = out.find("--"); at != std::string::npos; at = out.find("--")) out.replace(at, 2, "- -");
  return out;
}

std::string base64(const std::vector<uint8_t>& bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    const size_t left = bytes.size() - i;
    const unsigned group = static_cast<unsigned>(bytes[i]) << 16U |
                           (left > 1 ? static_cast<unsigned>(bytes[i + 1]) << 8U : 0U) |
                           (left > 2 ? static_cast<unsigned>(bytes[i + 2]) : 0U);
    out += kDigits[group >> 18U];
    out += kDigits[group >> 12U & 63U];
    out += left > 1 ? kDigits[group >> 6U & 63U] : '=';
    out += left > 2 ? kDigits[group & 63U] : '=';
  }
  return out;
}

}  // namespace crowdbench::reports
