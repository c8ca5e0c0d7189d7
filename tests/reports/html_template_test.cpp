#include "reports/page/html_template.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "reports/page/escape.h"
#include "reports/page/page_files.h"

namespace crowdbench::reports {
namespace {

std::string filled(std::string_view html, const TemplateValues& values) { return fill_template(html, values).text; }

// The mistake that filling names, or "none".
std::string mistake_of(std::string_view html, const TemplateValues& values) {
  try {
    fill_template(html, values);
  } catch (const std::logic_error& error) {
    return error.what();
  }
  return "none";
}

TEST(HtmlTemplate, TextIsEscapedAndReadyHtmlIsNot) {
  EXPECT_EQ(filled("<p title=\"{{a}}\">{{b}}{{c}}</p>",
                   {{"a", "\"<x>\""}, {"b", Html{"<b>&amp;</b>"}}, {"c", std::string("1 < 2 & 'so'")}}),
            "<p title=\"&quot;&lt;x&gt;&quot;\"><b>&amp;</b>1 &lt; 2 &amp; &#39;so&#39;</p>");
  EXPECT_EQ(filled("{{n}} {{m}}", {{"n", 12}, {"m", uint64_t{18446744073709551615U}}}), "12 18446744073709551615");
  EXPECT_EQ(filled("no place", {}), "no place");
  // What a value holds is never read as a template.
  EXPECT_EQ(filled("{{a}}{{b}}", {{"a", "{{b}}"}, {"b", Html{"{{#a}}"}}}), "{{b}}{{#a}}");
}

TEST(HtmlTemplate, SectionsRepeatForEachRowAndSeeWhatIsAround) {
  const TemplateValues values = {{"unit", "ms"}, {"rows", std::vector<TemplateValues>{{{"n", 1}}, {{"n", 2}}}}};
  EXPECT_EQ(filled("{{#rows}}[{{n}} {{unit}}]{{/rows}}", values), "[1 ms][2 ms]");
  // The row's own name hides the one around it.
  EXPECT_EQ(filled("{{n}}:{{#rows}}{{n}}{{/rows}}",
                   {{"n", "x"}, {"rows", std::vector<TemplateValues>{{{"n", 1}}, TemplateValues{}}}}),
            "x:1x");
  EXPECT_EQ(filled("{{#rows}}{{n}}{{/rows}}{{^rows}}none{{/rows}}", {{"rows", std::vector<TemplateValues>{}}}), "none");
}

TEST(HtmlTemplate, ConditionsShowOneSide) {
  const std::string html = "{{#on}}yes {{x}}{{/on}}{{^on}}no{{/on}}";
  EXPECT_EQ(filled(html, {{"on", true}, {"x", 1}}), "yes 1");
  EXPECT_EQ(filled(html, {{"on", false}, {"x", 1}}), "no");
}

TEST(HtmlTemplate, ATagOfASectionTakesItsOwnLineAway) {
  const TemplateValues values = {{"rows", std::vector<TemplateValues>{{{"n", 1}}, {{"n", 2}}}}};
  EXPECT_EQ(filled("<ul>\n  {{#rows}}  \n<li>{{n}}</li>\n{{/rows}}\n</ul>\n", values),
            "<ul>\n<li>1</li>\n<li>2</li>\n</ul>\n");
  // Not where something else stands on it.
  EXPECT_EQ(filled("<ul>\n{{#rows}} {{n}}\n{{/rows}}</ul>", values), "<ul>\n 1\n 2\n</ul>");
  EXPECT_EQ(filled("{{#rows}}\n{{n}}\n{{/rows}}", values), "1\n2\n");
}

TEST(HtmlTemplate, MistakesAreNamed) {
  EXPECT_EQ(mistake_of("{{a}}", {}), "template: a has no value");
  EXPECT_EQ(mistake_of("{{a}}", {{"a", 1}, {"b", 2}}), "template: value b has no place");
  EXPECT_EQ(mistake_of("{{#a}}{{/a}}{{n}}", {{"a", std::vector<TemplateValues>{{{"n", 1}}}}, {"n", 1}}),
            "template: value n has no place");                                             // of the row
  EXPECT_EQ(mistake_of("{{#a}}{{b}}{{/a}}", {{"a", false}}), "template: b has no value");  // though it is not shown
  EXPECT_EQ(mistake_of("{{a}}", {{"a", true}}), "template: a is a list or a condition, not a text");
  EXPECT_EQ(mistake_of("{{#a}}{{/a}}", {{"a", "x"}}), "template: a is a text, not a list or a condition");
  EXPECT_EQ(mistake_of("{{#a}}", {{"a", true}}), "template: section a has no end");
  EXPECT_EQ(mistake_of("{{#a}}{{#b}}{{/a}}{{/b}}", {{"a", true}, {"b", true}}), "template: section b is ended by a");
  EXPECT_EQ(mistake_of("{{/a}}", {{"a", true}}), "template: section (none) is ended by a");
  EXPECT_EQ(mistake_of("x {{a", {{"a", 1}}), "template: tag at byte 2 has no end");
  EXPECT_EQ(mistake_of("{{ a }}", {{"a", 1}}), "template: ' a ' is not a name (a-z, 0-9, _)");
  EXPECT_EQ(mistake_of("{{}}", {}), "template: '' is not a name (a-z, 0-9, _)");
}

TEST(PageFiles, AreThereByName) {
  EXPECT_TRUE(page_file("frame.html").starts_with("<!doctype html>"));
  EXPECT_TRUE(page_file("frame.html").ends_with("</html>"));
  EXPECT_NE(page_file("page.css").find(":root"), std::string_view::npos);
  EXPECT_THROW(page_file("absent.html"), std::logic_error);
}

TEST(Escapes, ByHand) {
  EXPECT_EQ(html_escape("<a href=\"x\">'&'</a>"), "&lt;a href=&quot;x&quot;&gt;&#39;&amp;&#39;&lt;/a&gt;");
  EXPECT_EQ(script_json(R"({"a":"</script><!--"})"), R"({"a":"\u003c/script>\u003c!--"})");
  EXPECT_EQ(inline_script("a=\"</script>\";b=\"<!--\"\n//# sourceMappingURL=x.map\n"),
            "a=\"<\\/script>\";b=\"<\\!--\"\n");
  EXPECT_EQ(inline_script("f()\n//# sourceMappingURL=x.map"), "f()");
  EXPECT_EQ(comment_text("a -- b --> c---"), "a - - b - -> c- - -");
  EXPECT_EQ(base64({}), "");
  EXPECT_EQ(base64({'f'}), "Zg==");
  EXPECT_EQ(base64({'f', 'o'}), "Zm8=");
  EXPECT_EQ(base64({'f', 'o', 'o', 'b', 'a', 'r'}), "Zm9vYmFy");
  EXPECT_EQ(base64({0xfb, 0xff, 0xfe}), "+//+");
}

}  // namespace
}  // namespace crowdbench::reports
