// The numbers of ColorVideoVDP that were fitted to people's answers.
//
// Source: github.com/gfxdisp/ColorVideoVDP, commit 7ca201a (version 0.5.6), pycvvdp/vvdp_data/cvvdp_parameters.json:
// the base model of 10 January 2024. MIT licence, Copyright (c) 2024 Graphics and Displays group: LICENSE beside this
// file.
#pragma once
#include <array>
#include <cstddef>

namespace crowdbench::metrics::vdp {

// Channels: achromatic sustained, red-green, violet-yellow, achromatic transient. A single picture has the first three.
constexpr size_t kStillChannels = 3;
constexpr size_t kChannels = 4;
template <typename T>
using PerChannel = std::array<T, kChannels>;

constexpr double kEps = 1e-5;  // of every power P(x, p) = (x + eps)^p - eps^p

// Temporal filters: H(w) = exp(-w^beta / sigma), of the transient one exp(-(w^beta - 5^beta)^2 / sigma).
constexpr PerChannel<double> kTemporalSigma = {5.79336, 14.1255, 6.63661, 0.12314};
constexpr PerChannel<double> kTemporalBeta = {1.3314, 1.1196, 0.947901, 0.1898};
constexpr double kTransientPeak = 5;     // Hz
constexpr double kFilterSeconds = 0.25;  // the taps' length

constexpr double kSensitivityCorrection = -0.2797423303127289;  // dB
constexpr PerChannel<double> kChannelGain = {1, 1.45, 1, 1};

constexpr double kMaskC = -0.7954971194267273;  // log10
constexpr double kMaskP = 2.264355182647705;
constexpr PerChannel<double> kMaskQ = {1.302622675895691, 2.8885908126831055, 3.6807713508605957, 3.588787317276001};
constexpr double kMaxDifference = 2.5642454624176025;  // log10
// log2 of how much channel [k] masks channel [c].
constexpr std::array<PerChannel<double>, kChannels> kCrossMasking = {
    {{-0.18950104713439941, -5.962151050567627, -4.31834602355957, -1.9321587085723877},
     {2.5655593872070312, 0.34406712651252747, -2.719646453857422, -0.4970424771308899},
     {3.8118371963500977, -1.0051705837249756, -0.5193376541137695, -0.5653647780418396},
     {-7.054771423339844, -5.527150630950928, -3.5106418132781982, -2.08804988861084}}};

constexpr PerChannel<double> kChannelWeight = {1, 1, 1, 0.8081134557723999};
constexpr PerChannel<double> kBaseWeight = {0.0036334486212581396, 1.6627724170684814, 4.11874532699585,
                                            25.25969886779785};
constexpr double kStillWeight = 0.577918291091919;
constexpr double kJodA = 0.0439569391310215;
constexpr double kJodExponent = 0.9302042722702026;

}  // namespace crowdbench::metrics::vdp
