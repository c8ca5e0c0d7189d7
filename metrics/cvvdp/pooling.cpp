#include "metrics/cvvdp/pooling.h"

#include <cmath>

namespace crowdbench::metrics::vdp {

double power(double x, double p) { return std::pow(x + kEps, p) - std::pow(kEps, p); }

double weight(size_t channel, bool base, bool still) {
  return kChannelWeight[channel] * (base ? kBaseWeight[channel] : 1) * (still ? kStillWeight : 1);
}

double channel_difference(const FrameQ& q, size_t channel) {
  double sum = 0;
  for (size_t b = 0; b < q[channel].size(); ++b)
    sum += power(weight(channel, b + 1 == q[channel].size(), false) * q[channel][b], 4);
  return power(sum, 0.25);
}

double frame_difference(const FrameQ& q) {
  double sum = 0;
  for (size_t c = 0; c < q.size(); ++c) sum += power(channel_difference(q, c), 4);
  return power(sum, 0.25);
}

double pooled(const std::vector<double>& frames, bool still) {
  if (still) return kStillWeight * frames.at(0);
  double sum = 0;
  for (const double q : frames) sum += power(q, 2);
  return power(sum / static_cast<double>(frames.size()), 0.5);
}

double jod_of(double q) {
  constexpr double kStraight = 0.1;
  if (q <= kStraight) return 10 - kJodA * std::pow(kStraight, kJodExponent - 1) * q;
  return 10 - kJodA * std::pow(q, kJodExponent);
}

}  // namespace crowdbench::metrics::vdp
