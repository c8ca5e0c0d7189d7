#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "reports/model/number_text.h"
#include "reports/page/page_files.h"
#include "reports/page/sections.h"

namespace crowdbench::reports {
namespace {

// The row of each representation with the most agents, which is where bytes that grow with the crowd are largest.
std::vector<const MeasurementRow*> largest_rows(const Scene& scene) {
  std::vector<const MeasurementRow*> rows;
  for (const std::string& name : scene.representations) {
    const MeasurementRow* largest = nullptr;
    for (const MeasurementRow* row : scene.rows)
      if (row->key.representation == name && is_timed(*row) &&
          (largest == nullptr || row->key.agents > largest->key.agents))
        largest = row;
    if (largest != nullptr) rows.push_back(largest);
  }
  return rows;
}

std::string bytes_or_dash(const std::optional<uint64_t>& bytes) { return bytes ? bytes_text(*bytes) : "–"; }

std::string bake_text(const MeasurementRow& row) {
  const std::string read =
      row.bake_load_seconds ? fmt::format("read from the cache in {:.2f} s", *row.bake_load_seconds) : "";
  if (!row.bake_seconds) return read.empty() ? "–" : "not known; " + read;  // files of schema 8 and before
  return fmt::format("{:.2f} s{}", *row.bake_seconds, read.empty() ? "" : "; " + read);
}

}  // namespace

Html memory_section(const SceneOnPage& page) {
  const auto largest = largest_rows(page.scene);
  if (std::none_of(largest.begin(), largest.end(),
                   [](const MeasurementRow* row) { return row->texture_bytes.has_value(); }))
    return {};
  std::vector<TemplateValues> rows;
  for (const MeasurementRow* row : largest) {
    std::optional<uint64_t> on_gpu;
    if (row->texture_bytes && row->buffer_bytes) on_gpu = *row->texture_bytes + *row->buffer_bytes;
    rows.push_back({{"representation", page.mark(row->key.representation)},
                    {"textures", bytes_or_dash(row->texture_bytes)},
                    {"buffers", bytes_or_dash(row->buffer_bytes)},
                    {"on_gpu", bytes_or_dash(on_gpu)},
                    {"upload", bytes_or_dash(row->upload_bytes_per_frame)},
                    {"disk", bytes_or_dash(row->disk_bytes)},
                    {"shared", bytes_or_dash(row->shared_bytes)},
                    {"bake", bake_text(*row)}});
  }
  return fill_template(page_file("memory.html"), {{"rows", std::move(rows)}});
}

}  // namespace crowdbench::reports
