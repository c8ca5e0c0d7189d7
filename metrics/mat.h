// cv::Mat at the door of OpenCV's functions: a view of a core image's own memory, no copy. The image must outlive the
// view. Colour order stays R, G, B.
#pragma once
#include <opencv2/core.hpp>

#include "core/image.h"

namespace crowdbench::metrics {

template <typename T>
cv::Mat view(Image<T>& image) {
  return cv::Mat(image.height, image.width, CV_MAKETYPE(cv::DataType<T>::depth, image.channels), image.data.data());
}
// OpenCV has no read-only matrix: only pass this on as an input.
template <typename T>
cv::Mat view(const Image<T>& image) {
  return view(const_cast<Image<T>&>(image));
}

}  // namespace crowdbench::metrics
