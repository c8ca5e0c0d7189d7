#include "reports/page/libraries.h"

#include "core/error.h"

#ifdef CROWDBENCH_HAS_CHART_LIBRARIES
extern "C" {
extern const char crowdbench_vega_js_begin[], crowdbench_vega_js_end[];
extern const char crowdbench_vega_licence_begin[], crowdbench_vega_licence_end[];
extern const char crowdbench_vega_lite_js_begin[], crowdbench_vega_lite_js_end[];
extern const char crowdbench_vega_lite_licence_begin[], crowdbench_vega_lite_licence_end[];
extern const char crowdbench_vega_embed_js_begin[], crowdbench_vega_embed_js_end[];
extern const char crowdbench_vega_embed_licence_begin[], crowdbench_vega_embed_licence_end[];
}
#endif

namespace crowdbench::reports {

#ifdef CROWDBENCH_HAS_CHART_LIBRARIES

const std::vector<Library>& chart_libraries() {
  static const std::vector<Library> all = {{"Vega",
                                            {crowdbench_vega_js_begin, crowdbench_vega_js_end},
                                            {crowdbench_vega_licence_begin, crowdbench_vega_licence_end}},
                                           {"Vega-Lite",
                                            {crowdbench_vega_lite_js_begin, crowdbench_vega_lite_js_end},
                                            {crowdbench_vega_lite_licence_begin, crowdbench_vega_lite_licence_end}},
                                           {"Vega-Embed",
                                            {crowdbench_vega_embed_js_begin, crowdbench_vega_embed_js_end},
                                            {crowdbench_vega_embed_licence_begin, crowdbench_vega_embed_licence_end}}};
  return all;
}

#else

const std::vector<Library>& chart_libraries() {
  throw Error("report", "this program was built without the chart library",
              "run `npm ci` in the source folder and build again (./run build does both); the other exports work "
              "without it");
}

#endif

}  // namespace crowdbench::reports
