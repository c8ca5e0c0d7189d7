// FFmpeg's libraries behind the interface of video_api.h.
//
// What is fixed here, and why: x264's thread count (four threads decode to another video than two), the bit-exact flags
// (no encoder version or date in the file), a key frame a second (seeking in a browser), exact time stamps n / fps, and
// every colour tag, so that no player has to guess the matrix. swscale's fast RGB reader reads up to 16 bytes past the
// last row: pictures that it touches live in buffers that FFmpeg pads.
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "studies/stimuli/module/video_api.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
#include <libswscale/swscale.h>
}

namespace crowdbench::studies::video {

struct Encoder {
  AVFormatContext* format = nullptr;
  AVCodecContext* codec = nullptr;
  AVStream* stream = nullptr;
  SwsContext* scaler = nullptr;  // null for RGB
  AVFrame* rgb = nullptr;
  AVFrame* coded = nullptr;  // what the encoder takes; the same as `rgb` for RGB
  AVPacket* packet = nullptr;
  int64_t next = 0;
};

struct Decoder {
  AVFormatContext* format = nullptr;
  AVCodecContext* codec = nullptr;
  SwsContext* scaler = nullptr;
  AVFrame* rgb = nullptr;
  AVFrame* coded = nullptr;
  AVPacket* packet = nullptr;
  int stream = -1;
  bool draining = false;
};

namespace {

constexpr int kScaleFlags = SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP | SWS_BITEXACT;

bool fail(char* message, const char* step, int status = 0) {
  char reason[AV_ERROR_MAX_STRING_SIZE] = "out of memory or not supported by this build of FFmpeg";
  if (status < 0) av_strerror(status, reason, sizeof reason);
  std::snprintf(message, kMessageBytes, "%s: %s", step, reason);
  return false;
}

// A frame whose buffer is owned and padded by FFmpeg.
AVFrame* make_frame(AVPixelFormat format, int width, int height) {
  AVFrame* frame = av_frame_alloc();
  if (!frame) return nullptr;
  frame->format = format;
  frame->width = width;
  frame->height = height;
  if (av_frame_get_buffer(frame, 0) < 0) av_frame_free(&frame);
  return frame;
}

// Full-range RGB on one side, BT.709 limited-range YUV on the other.
SwsContext* make_scaler(int width, int height, AVPixelFormat from, AVPixelFormat to, bool to_yuv) {
  SwsContext* scaler = sws_getContext(width, height, from, width, height, to, kScaleFlags, nullptr, nullptr, nullptr);
  if (!scaler) return nullptr;
  const int* bt709 = sws_getCoefficients(SWS_CS_ITU709);
  if (sws_setColorspaceDetails(scaler, bt709, to_yuv ? 1 : 0, bt709, to_yuv ? 0 : 1, 0, 1 << 16, 1 << 16) < 0) {
    sws_freeContext(scaler);
    return nullptr;
  }
  return scaler;
}

void free_encoder(Encoder* e) {
  if (!e) return;
  if (e->coded != e->rgb) av_frame_free(&e->coded);
  av_frame_free(&e->rgb);
  av_packet_free(&e->packet);
  sws_freeContext(e->scaler);
  avcodec_free_context(&e->codec);
  if (e->format) {
    if (e->format->pb) avio_closep(&e->format->pb);
    avformat_free_context(e->format);
  }
  delete e;
}

// x264's choices must not depend on the processor; and its AVX-512 code (build 164) reads memory that it never wrote,
// so that the same pictures became another video in every run of a busy machine. A processor with AVX-512 has what is
// named here.
const char* same_everywhere() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f")) return "cpu-independent=1:asm=AVX2,FMA3,BMI2,LZCNT";
#endif
  return "cpu-independent=1";
}

// The rate factor and how much time is spent on it.
int set_quality(AVCodecContext& c, const Settings& settings) {
  const char* const speed = settings.codec == Codec::vp9_444 ? "cpu-used" : "preset";
  int status = av_opt_set(c.priv_data, speed, settings.preset, 0);
  if (status >= 0 && settings.codec != Codec::vp9_444)
    status = av_opt_set(c.priv_data, "x264-params", same_everywhere(), 0);
  if (status >= 0 && settings.codec == Codec::h264_lossless) return av_opt_set_int(c.priv_data, "qp", 0, 0);
  if (status >= 0 && settings.codec != Codec::vp9_444) return av_opt_set_double(c.priv_data, "crf", settings.crf, 0);
  // No bit rate beside the rate factor: constant quality. Rows and two columns are encoded at a time; the bytes are the
  // same whatever the number of threads.
  c.bit_rate = 0;
  if (status >= 0) status = av_opt_set_int(c.priv_data, "crf", settings.crf, 0);
  if (status >= 0) status = av_opt_set(c.priv_data, "deadline", "good", 0);
  if (status >= 0) status = av_opt_set_int(c.priv_data, "row-mt", 1, 0);
  if (status >= 0) status = av_opt_set_int(c.priv_data, "tile-columns", 1, 0);
  return status;
}

bool open_codec(Encoder& e, const Settings& settings, char* message) {
  const bool lossless = settings.codec == Codec::h264_lossless;
  const bool vp9 = settings.codec == Codec::vp9_444;
  const char* name = vp9 ? "libvpx-vp9" : lossless ? "libx264rgb" : "libx264";
  const AVCodec* codec = avcodec_find_encoder_by_name(name);
  if (!codec) return fail(message, name);
  e.codec = avcodec_alloc_context3(codec);
  if (!e.codec) return fail(message, "encoder");
  AVCodecContext& c = *e.codec;
  c.width = settings.width;
  c.height = settings.height;
  c.time_base = {1, settings.fps};
  c.framerate = {settings.fps, 1};
  c.sample_aspect_ratio = {1, 1};
  c.gop_size = settings.fps;
  c.thread_count = settings.threads;
  c.flags |= AV_CODEC_FLAG_BITEXACT | AV_CODEC_FLAG_GLOBAL_HEADER;
  c.color_primaries = AVCOL_PRI_BT709;
  c.color_trc = AVCOL_TRC_BT709;
  if (lossless) {
    c.pix_fmt = AV_PIX_FMT_RGB24;
    c.colorspace = AVCOL_SPC_RGB;
    c.color_range = AVCOL_RANGE_JPEG;
  } else {
    c.pix_fmt = settings.codec == Codec::h264_420 ? AV_PIX_FMT_YUV420P : AV_PIX_FMT_YUV444P;
    c.colorspace = AVCOL_SPC_BT709;
    c.color_range = AVCOL_RANGE_MPEG;
    if (c.pix_fmt == AV_PIX_FMT_YUV420P) c.chroma_sample_location = AVCHROMA_LOC_LEFT;
  }
  int status = set_quality(c, settings);
  if (status < 0) return fail(message, "encoder options", status);
  status = avcodec_open2(&c, codec, nullptr);
  return status < 0 ? fail(message, "opening the encoder", status) : true;
}

bool open_file(Encoder& e, const char* path, const Settings& settings, char* message) {
  e.stream = avformat_new_stream(e.format, nullptr);
  if (!e.stream) return fail(message, "video stream");
  e.stream->time_base = e.codec->time_base;
  e.stream->avg_frame_rate = e.codec->framerate;
  int status = avcodec_parameters_from_context(e.stream->codecpar, e.codec);
  if (status < 0) return fail(message, "video stream", status);
  if (settings.title) av_dict_set(&e.format->metadata, "title", settings.title, 0);
  status = avio_open(&e.format->pb, path, AVIO_FLAG_WRITE);
  if (status < 0) return fail(message, "creating the file", status);
  AVDictionary* options = nullptr;
  av_dict_set(&options, "movflags", "+faststart", 0);
  status = avformat_write_header(e.format, &options);
  av_dict_free(&options);
  return status < 0 ? fail(message, "writing the header", status) : true;
}

Encoder* open_encoder(const char* path, const Settings* settings, char* message) {
  av_log_set_level(AV_LOG_FATAL);  // reasons come back in `message`
  auto* e = new Encoder;
  bool fine = avformat_alloc_output_context2(&e->format, nullptr, settings->codec == Codec::vp9_444 ? "webm" : "mp4",
                                             path) >= 0;
  if (fine) {
    e->format->flags |= AVFMT_FLAG_BITEXACT;
  } else {
    fail(message, "container");
  }
  fine = fine && open_codec(*e, *settings, message) && open_file(*e, path, *settings, message);
  if (fine) {
    const AVPixelFormat coded = e->codec->pix_fmt;
    e->rgb = make_frame(AV_PIX_FMT_RGB24, settings->width, settings->height);
    e->coded = coded == AV_PIX_FMT_RGB24 ? e->rgb : make_frame(coded, settings->width, settings->height);
    e->packet = av_packet_alloc();
    if (coded != AV_PIX_FMT_RGB24) {
      e->scaler = make_scaler(settings->width, settings->height, AV_PIX_FMT_RGB24, coded, true);
    }
    fine = e->rgb && e->coded && e->packet && (e->scaler || coded == AV_PIX_FMT_RGB24);
    if (!fine) fail(message, "picture buffers");
  }
  if (!fine) {
    free_encoder(e);
    return nullptr;
  }
  return e;
}

// Hands what the encoder has ready to the container. frame null: flush.
bool send(Encoder& e, const AVFrame* frame, char* message) {
  int status = avcodec_send_frame(e.codec, frame);
  if (status < 0) return fail(message, "encoding", status);
  while ((status = avcodec_receive_packet(e.codec, e.packet)) >= 0) {
    e.packet->stream_index = e.stream->index;
    e.packet->duration = 1;
    av_packet_rescale_ts(e.packet, e.codec->time_base, e.stream->time_base);
    status = av_interleaved_write_frame(e.format, e.packet);
    if (status < 0) return fail(message, "writing the file", status);
  }
  return status == AVERROR(EAGAIN) || status == AVERROR_EOF ? true : fail(message, "encoding", status);
}

bool encode(Encoder* e, const uint8_t* rgb, char* message) {
  int status = av_frame_make_writable(e->rgb);
  if (status >= 0 && e->coded != e->rgb) status = av_frame_make_writable(e->coded);
  if (status < 0) return fail(message, "picture buffers", status);
  const auto row = static_cast<size_t>(e->codec->width) * 3;
  for (int y = 0; y < e->codec->height; ++y) {
    std::memcpy(e->rgb->data[0] + static_cast<ptrdiff_t>(y) * e->rgb->linesize[0], rgb + static_cast<size_t>(y) * row,
                row);
  }
  if (e->scaler) {
    sws_scale(e->scaler, e->rgb->data, e->rgb->linesize, 0, e->codec->height, e->coded->data, e->coded->linesize);
  }
  e->coded->pts = e->next++;
  return send(*e, e->coded, message);
}

bool finish(Encoder* e, char* message) {
  if (!send(*e, nullptr, message)) return false;
  int status = av_write_trailer(e->format);
  if (status < 0) return fail(message, "writing the index", status);
  status = avio_closep(&e->format->pb);
  return status < 0 ? fail(message, "closing the file", status) : true;
}

void free_decoder(Decoder* d) {
  if (!d) return;
  av_frame_free(&d->rgb);
  av_frame_free(&d->coded);
  av_packet_free(&d->packet);
  sws_freeContext(d->scaler);
  avcodec_free_context(&d->codec);
  avformat_close_input(&d->format);
  delete d;
}

template <size_t N>
void copy_name(char (&to)[N], const char* name, std::string_view unknown = "unknown") {
  if (!name || name == unknown) name = "";
  std::snprintf(to, N, "%s", name);
}

bool open_input(Decoder& d, const char* path, Info& info, char* message) {
  int status = avformat_open_input(&d.format, path, nullptr, nullptr);
  if (status < 0) return fail(message, "opening the file", status);
  status = avformat_find_stream_info(d.format, nullptr);
  if (status < 0) return fail(message, "reading the file", status);
  const AVCodec* codec = nullptr;
  d.stream = av_find_best_stream(d.format, AVMEDIA_TYPE_VIDEO, -1, -1, &codec, 0);
  if (d.stream < 0) return fail(message, "finding a video stream", d.stream);
  const AVStream& stream = *d.format->streams[d.stream];
  d.codec = avcodec_alloc_context3(codec);
  if (!d.codec) return fail(message, "decoder");
  status = avcodec_parameters_to_context(d.codec, stream.codecpar);
  d.codec->thread_count = 2;
  if (status >= 0) status = avcodec_open2(d.codec, codec, nullptr);
  if (status < 0) return fail(message, "opening the decoder", status);
  const AVCodecContext& c = *d.codec;
  d.coded = av_frame_alloc();
  d.packet = av_packet_alloc();
  d.rgb = make_frame(AV_PIX_FMT_RGB24, c.width, c.height);
  const bool rgb_coded = c.colorspace == AVCOL_SPC_RGB;
  d.scaler = rgb_coded ? sws_getContext(c.width, c.height, c.pix_fmt, c.width, c.height, AV_PIX_FMT_RGB24, kScaleFlags,
                                        nullptr, nullptr, nullptr)
                       : make_scaler(c.width, c.height, c.pix_fmt, AV_PIX_FMT_RGB24, false);
  if (!d.coded || !d.packet || !d.rgb || !d.scaler) return fail(message, "picture buffers");
  info.width = c.width;
  info.height = c.height;
  info.fps_numerator = stream.avg_frame_rate.num;
  info.fps_denominator = stream.avg_frame_rate.den;
  info.frames = stream.nb_frames;
  if (info.frames <= 0 && d.format->duration > 0 && stream.avg_frame_rate.num > 0)
    info.frames = av_rescale_q(d.format->duration, {1, AV_TIME_BASE}, av_inv_q(stream.avg_frame_rate));
  if (stream.duration > 0)
    info.duration_us = av_rescale_q(stream.duration, stream.time_base, {1, AV_TIME_BASE});
  else if (d.format->duration > 0)
    info.duration_us = d.format->duration;
  copy_name(info.codec, avcodec_get_name(c.codec_id));
  copy_name(info.pixel_format, av_get_pix_fmt_name(c.pix_fmt));
  copy_name(info.primaries, av_color_primaries_name(c.color_primaries));
  copy_name(info.transfer, av_color_transfer_name(c.color_trc));
  copy_name(info.matrix, av_color_space_name(c.colorspace));
  copy_name(info.range, av_color_range_name(c.color_range));
  const AVDictionaryEntry* title = av_dict_get(d.format->metadata, "title", nullptr, 0);
  copy_name(info.title, title ? title->value : nullptr, {});
  return true;
}

Decoder* open_decoder(const char* path, Info* info, char* message) {
  av_log_set_level(AV_LOG_FATAL);
  auto* d = new Decoder;
  if (!open_input(*d, path, *info, message)) {
    free_decoder(d);
    return nullptr;
  }
  return d;
}

int32_t decode(Decoder* d, uint8_t* rgb, FrameInfo* info, char* message) {
  int status = 0;
  while ((status = avcodec_receive_frame(d->codec, d->coded)) == AVERROR(EAGAIN)) {
    if (d->draining) return 0;
    status = av_read_frame(d->format, d->packet);
    if (status == AVERROR_EOF) {
      d->draining = true;
      status = avcodec_send_packet(d->codec, nullptr);
    } else if (status >= 0) {
      if (d->packet->stream_index == d->stream) status = avcodec_send_packet(d->codec, d->packet);
      av_packet_unref(d->packet);
    }
    if (status < 0) {
      fail(message, "reading a frame", status);
      return -1;
    }
  }
  if (status == AVERROR_EOF) return 0;
  if (status < 0 || d->coded->width != d->codec->width || d->coded->height != d->codec->height) {
    fail(message, "decoding a frame", status);
    return -1;
  }
  sws_scale(d->scaler, d->coded->data, d->coded->linesize, 0, d->codec->height, d->rgb->data, d->rgb->linesize);
  const auto row = static_cast<size_t>(d->codec->width) * 3;
  for (int y = 0; y < d->codec->height; ++y) {
    std::memcpy(rgb + static_cast<size_t>(y) * row, d->rgb->data[0] + static_cast<ptrdiff_t>(y) * d->rgb->linesize[0],
                row);
  }
  const AVStream& stream = *d->format->streams[d->stream];
  info->pts = d->coded->best_effort_timestamp;
  info->time_base_numerator = stream.time_base.num;
  info->time_base_denominator = stream.time_base.den;
  info->key = d->coded->key_frame;
  return 1;
}

}  // namespace
}  // namespace crowdbench::studies::video

extern "C" __attribute__((visibility("default"))) const crowdbench::studies::video::Api* crowdbench_video_api() {
  using namespace crowdbench::studies::video;
  static const Api api = {kApiVersion, open_encoder, encode, finish, free_encoder, open_decoder, decode, free_decoder};
  return &api;
}
