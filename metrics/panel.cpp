#include "metrics/panel.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "metrics/mat.h"

namespace crowdbench::metrics {
namespace {

constexpr double kPanelText = 0.4;
constexpr int kPanelLine = 16;  // pixels from one baseline to the next
constexpr int kPanelEdge = 4;

int words_width(const std::string& words) {
  int below = 0;
  return cv::getTextSize(words, cv::FONT_HERSHEY_SIMPLEX, kPanelText, 1, &below).width + 2 * kPanelEdge;
}

// The longest beginning that is no wider than `widest` and ends where a line may, else the shortest that so ends.
size_t break_of(const std::string& line, int widest) {
  size_t best = 0;
  for (size_t at = line.find_first_of(" ,|"); at != std::string::npos; at = line.find_first_of(" ,|", at + 1)) {
    if (best > 0 && words_width(line.substr(0, at + 1)) > widest) break;
    best = at + 1;
  }
  return best;
}

std::vector<std::string> broken(const std::string& line, int widest) {
  std::vector<std::string> out;
  std::string rest = line;
  while (words_width(rest) > widest) {
    const size_t at = break_of(rest, widest);
    if (at == 0 || at == rest.size()) break;
    out.push_back(rest.substr(0, at));
    rest.erase(0, rest.find_first_not_of(' ', at));
  }
  out.push_back(rest);
  return out;
}

}  // namespace

Image8 with_words_above(const Image8& picture, std::span<const std::string> lines, int widest) {
  std::vector<std::string> drawn;
  int width = picture.width;
  for (const std::string& line : lines)
    for (std::string& piece : broken(line, std::max(widest, picture.width))) {
      width = std::max(width, words_width(piece));
      drawn.push_back(std::move(piece));
    }
  const int top = drawn.empty() ? 0 : kPanelLine * static_cast<int>(drawn.size()) + kPanelEdge;
  Image8 out(width, top + picture.height, 3);
  std::fill(out.data.begin(), out.data.end(), uint8_t{64});
  const cv::Mat canvas = view(out);
  for (size_t i = 0; i < drawn.size(); ++i)
    cv::putText(canvas, drawn[i], {kPanelEdge, kPanelLine * (static_cast<int>(i) + 1) - kPanelEdge},
                cv::FONT_HERSHEY_SIMPLEX, kPanelText, cv::Scalar(230, 230, 230), 1, cv::LINE_AA);
  const int left = (width - picture.width) / 2;
  for (int y = 0; y < picture.height; ++y)
    std::copy_n(picture.at(0, y), 3 * static_cast<size_t>(picture.width), out.at(left, top + y));
  return out;
}

}  // namespace crowdbench::metrics
