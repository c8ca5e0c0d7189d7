#include <gtest/gtest.h>

#include "core/error.h"
#include "renderers/representation.h"

namespace crowdbench::renderers {
namespace {

const std::vector<RepresentationType>& table() {
  static const std::vector<RepresentationType> types = {
      {"mesh", "", {}, {}},
      {"relief", "", {{"search", "linear|cone", "linear", ""}, {"steps", "N+M", "16+7", ""}}, {}},
      {"hybrid", "", {{"distance", "0..1000", "20", ""}}, {}, 2},
  };
  return types;
}

struct Good {
  const char* text;
  const char* canonical;
};

TEST(Spec, CanonicalText) {
  const Good good[] = {
      {"mesh", "mesh"},
      {"mesh:floor=0", "mesh"},
      {"mesh:floor=1", "mesh:floor=1"},
      {"relief:steps=8+5,search=cone", "relief:search=cone,steps=8+5"},
      {"relief:search=linear,steps=16+7", "relief"},
      {"relief:steps=4+3,floor=1", "relief:steps=4+3,floor=1"},
      {"hybrid(mesh,relief)", "hybrid(mesh,relief)"},
      {"hybrid(mesh,relief,distance=12.5)", "hybrid(mesh,relief,distance=12.5)"},
      {"hybrid(mesh,relief,distance=20)", "hybrid(mesh,relief,distance=20)"},
      // The key is known to the component before it, so it is that one's.
      {"hybrid(mesh,relief:search=cone,steps=8+5,distance=9)",
       "hybrid(mesh,(relief:search=cone,steps=8+5),distance=9)"},
      {"hybrid(mesh,(relief:search=cone),distance=9)", "hybrid(mesh,(relief:search=cone),distance=9)"},
      // Both know `floor`: the open component takes it, a closed one leaves it to the hybrid.
      {"hybrid(mesh,relief:steps=8+5,floor=1)", "hybrid(mesh,(relief:steps=8+5,floor=1))"},
      {"hybrid(mesh,(relief:steps=8+5),floor=1)", "hybrid(mesh,(relief:steps=8+5),floor=1)"},
      {"hybrid(mesh,relief,floor=1)", "hybrid(mesh,relief,floor=1)"},
      {"hybrid(mesh,hybrid(relief:steps=1+1,mesh,distance=5),distance=3)",
       "hybrid(mesh,hybrid((relief:steps=1+1),mesh,distance=5),distance=3)"},
  };
  for (const Good& g : good) {
    SCOPED_TRACE(g.text);
    const Spec spec = parse_spec(g.text, table());
    const std::string text = canonical_text(spec, table());
    EXPECT_EQ(text, g.canonical);
    EXPECT_EQ(canonical_text(parse_spec(text, table()), table()), text) << "the canonical text is its own";
  }
}

TEST(Spec, OptionsAreKeptInOrder) {
  const Spec spec = parse_spec("hybrid(mesh,relief:steps=8+5,search=cone,distance=9)", table());
  EXPECT_EQ(spec.name, "hybrid");
  ASSERT_EQ(spec.components.size(), 2U);
  EXPECT_EQ(spec.components[0].name, "mesh");
  const std::vector<std::pair<std::string, std::string>> relief = {{"steps", "8+5"}, {"search", "cone"}};
  EXPECT_EQ(spec.components[1].options, relief);
  const std::vector<std::pair<std::string, std::string>> own = {{"distance", "9"}};
  EXPECT_EQ(spec.options, own);
}

struct Bad {
  const char* text;
  const char* says;
};

TEST(Spec, RefusalsSayWhat) {
  const Bad bad[] = {
      {"", "a name is missing"},
      {"messh", "did you mean 'mesh'"},
      {"zzzzzzzz", "there is no representation"},
      {"relief:", "is not key=value"},
      {"relief:steps", "is not key=value"},
      {"relief:steps=", "has no value"},
      {"relief:=4", "is not key=value"},
      {"relief:step=4", "did you mean 'steps'"},
      {"relief:steps=1+1,steps=2+2", "is given twice"},
      {"relief:steps=1+1,", "is not key=value"},
      {"relief,steps=1", "is left over"},
      {"mesh()", "a name is missing"},
      {"mesh(mesh)", "takes no components"},
      {"hybrid", "takes 2 components"},
      {"hybrid(mesh)", "takes 2 components"},
      {"hybrid(mesh,mesh,mesh)", "takes 2 components"},
      {"hybrid(mesh,mesh", "')' is missing"},
      {"hybrid(mesh,(mesh", "')' is missing"},
      {"hybrid(mesh,mesh))", "is left over"},
      {"hybrid(mesh,distance=3,mesh)", "a component follows an option"},
      {"hybrid(mesh,mesh,steps=3)", "there is no option 'steps'"},
      {"hybrid(mesh,(relief:steps=1+1,distance=4))", "there is no option 'distance'"},
      {"hybrid(mesh,hybrid(mesh,hybrid(mesh,hybrid(mesh,hybrid(mesh,hybrid(mesh,mesh))))))", "go too deep"},
      {"mesh\n", "there is no representation"},
  };
  for (const Bad& b : bad) {
    SCOPED_TRACE(b.text);
    try {
      (void)parse_spec(b.text, table());
      ADD_FAILURE() << "was accepted";
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find(b.says), std::string::npos) << e.what();
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << "one line";
    }
  }
  EXPECT_THROW((void)parse_spec(std::string(5000, 'm'), table()), Error);
}

TEST(Spec, ReaderGivesDefaultsAndRefusesOutOfRange) {
  const RepresentationType type = {
      "x", "", {{"n", "1..8", "4", ""}, {"r", "0..1", "0.5", ""}, {"w", "a|b", "b", ""}}, {}};
  const OptionReader defaults(type, Spec{"x", {}, {}});
  EXPECT_EQ(defaults.integer("n", 1, 8), 4);
  EXPECT_EQ(defaults.number("r", 0, 1), 0.5);
  EXPECT_EQ(defaults.choice("w", {"a", "b"}), 1U);
  EXPECT_FALSE(defaults.flag("floor"));
  const auto reader = [&](const char* key, const char* value) {
    return OptionReader(type, Spec{"x", {{key, value}}, {}});
  };
  EXPECT_EQ(reader("n", "8").integer("n", 1, 8), 8);
  EXPECT_THROW((void)reader("n", "9").integer("n", 1, 8), Error);
  EXPECT_THROW((void)reader("n", "4x").integer("n", 1, 8), Error);
  EXPECT_THROW((void)reader("n", "99999999999999999999").integer("n", 1, 8), Error);
  EXPECT_THROW((void)reader("r", "nan").number("r", 0, 1), Error);
  EXPECT_THROW((void)reader("r", "1.01").number("r", 0, 1), Error);
  EXPECT_THROW((void)reader("w", "c").choice("w", {"a", "b"}), Error);
  EXPECT_THROW((void)reader("floor", "yes").flag("floor"), Error);
}

TEST(Spec, ReferenceStandsForItsName) {
  EXPECT_EQ(parse_spec("reference").text(), reference_type().name);
  EXPECT_EQ(parse_spec("reference:floor=1").text(), reference_type().name + ":floor=1");
  EXPECT_EQ(reference_spec().text(), reference_type().name);
  EXPECT_THROW((void)parse_spec("reference", table()), Error) << "a table without one";
}

TEST(Spec, FloorsAreAskedForAndToldApart) {
  EXPECT_EQ(with_floor(parse_spec("flat:texels=64,floor=0")).text(), "flat:texels=64,floor=1");
  EXPECT_TRUE(is_floor(with_floor(reference_spec())));
  EXPECT_FALSE(is_floor(reference_spec()));
  EXPECT_FALSE(is_floor(parse_spec("flat:floor=0")));
}

TEST(Spec, CapabilitiesFitTogether) {
  size_t references = 0;
  for (const RepresentationType& type : representation_types()) {
    SCOPED_TRACE(type.name);
    references += type.reference ? 1 : 0;
    const Spec example = parse_spec(example_spec(type));
    EXPECT_EQ(example.name, type.name);
    EXPECT_EQ(example.text(), example_spec(type)) << "canonical";
    EXPECT_EQ(honours_required_by(example), type.required_by || !stands_alone(type)) << "made of one that does";
    EXPECT_FALSE(type.floor.empty());
    EXPECT_EQ(floors_by_name().at(type.name), type.floor);
    for (const std::string& view : debug_views(type)) {
      EXPECT_NE(view, "none");
      EXPECT_NE(debug_views_of_all().find(type.name + " has "), std::string::npos);
      EXPECT_NE(debug_views_of_all().find(view), std::string::npos);
    }
  }
  EXPECT_EQ(references, 1U);
  EXPECT_NE(representation_type(default_impostor().name).view_sampling, nullptr);
  EXPECT_EQ(debug_views(representation_type("relief")),
            (std::vector<std::string>{"boxes", "steps", "hit-face", "misses"}));
}

TEST(Spec, EveryTypeDocumentsItself) {
  for (const RepresentationType& type : representation_types()) {
    SCOPED_TRACE(type.name);
    EXPECT_FALSE(type.summary.empty());
    EXPECT_EQ(type.summary.find('\n'), std::string::npos);
    EXPECT_TRUE(type.make);
    for (const OptionDoc& o : option_docs(type)) {
      EXPECT_FALSE(o.values.empty()) << o.key;
      EXPECT_FALSE(o.default_value.empty()) << o.key;
      EXPECT_FALSE(o.meaning.empty()) << o.key;
    }
  }
}

TEST(Spec, DebugViewsAreAnOptionOfTheRepresentation) {
  const auto with = [](const std::string& text, const std::string& view) {
    Spec spec = parse_spec(text);
    set_debug_view(spec, view);
    return spec.text();
  };
  EXPECT_EQ(with("relief", "steps"), "relief:debug=steps");
  EXPECT_EQ(with("relief:debug=boxes,map=64", "hit-face"), "relief:map=64,debug=hit-face");
  EXPECT_EQ(with("relief:debug=boxes", "none"), "relief");
  EXPECT_EQ(with("polypostor", "wire"), "polypostor:debug=wire");
  EXPECT_EQ(with("hybrid(mesh,relief)", "misses"), "hybrid(mesh,(relief:debug=misses))");
  EXPECT_EQ(with("hybrid(relief,polypostor)", "lines"), "hybrid(relief,(polypostor:debug=lines))");
  const auto said = [&](const std::string& text, const std::string& view) -> std::string {
    try {
      with(text, view);
    } catch (const Error& e) {
      return e.what();
    }
    return "nothing";
  };
  EXPECT_NE(said("relief", "wire").find("it has boxes, steps, hit-face, misses"), std::string::npos);
  EXPECT_NE(said("polypostor", "steps").find("wire, lines, parts, stretch"), std::string::npos);
  EXPECT_NE(said("mesh", "steps").find("'mesh' has no debug views"), std::string::npos);
  EXPECT_NE(said("relief", "stps").find("did you mean 'steps'?"), std::string::npos);
}

// Before anything is opened; what the table does not say in full is left to the representation.
TEST(ParseSpec, ValuesAreHeldToTheTableOfOptions) {
  const auto said = [](const std::string& text) -> std::string {
    try {
      parse_spec(text);
    } catch (const Error& e) {
      return e.what();
    }
    return "nothing";
  };
  EXPECT_EQ(said("flat:texels=3"), "representation 'flat': option texels=3 is not a number from 16 to 1024");
  EXPECT_EQ(said("flat:texels=many"), "representation 'flat': option texels=many is not a number from 16 to 1024");
  EXPECT_EQ(said("relief:search=cnoe"),
            "representation 'relief': option search=cnoe is not one of adaptive, linear, cone; did you mean 'cone'?");
  EXPECT_NE(said("hybrid(mesh,(flat:blend=2))").find("option blend=2 is not one of 1, 3"), std::string::npos);
  for (const char* fine : {"flat:texels=16", "relief:bias=-4", "relief:rule=threshold1.5", "relief:capture=walk@0.5",
                           "relief:merge=0.1", "relief:search=cone"})
    EXPECT_EQ(said(fine), "nothing") << fine;
}

TEST(ParseSpecs, CommasSeparateRepresentationsAndOptionsAlike) {
  const auto specs = parse_specs("mesh,mesh:floor=1,mesh");
  ASSERT_EQ(specs.size(), 3U);
  EXPECT_EQ(specs[0].text(), "mesh");
  EXPECT_EQ(specs[1].text(), "mesh:floor=1");
  EXPECT_THROW(parse_specs("mesh,nothing-like-it"), Error);
  EXPECT_THROW(parse_specs("mesh,floor=1"), Error);  // the option of a representation without a colon
  EXPECT_THROW(parse_specs("mesh,,mesh"), Error);
}

}  // namespace
}  // namespace crowdbench::renderers
