#version 450 core
// Many samples a texel down to one: the fraction that is covered, the covered samples' mean colour in linear light, the
// material id that most of them have, and the mean normal and depth of the samples with that id.
layout(binding = 0) uniform sampler2D albedo_samples;
layout(binding = 1) uniform sampler2D surface_samples;
layout(location = 0) out vec4 out_albedo;
layout(location = 1) out vec4 out_surface;

const int kSide = CB_SAMPLES;

void main() {
  ivec2 corner = ivec2(gl_FragCoord.xy) * kSide;
  vec3 colour = vec3(0.0);
  int covered = 0;
  int ids[kSide * kSide];
  for (int i = 0; i < kSide * kSide; ++i) {
    vec4 a = texelFetch(albedo_samples, corner + ivec2(i % kSide, i / kSide), 0);
    ids[i] = -1;
    if (a.a > 0.5) {
      colour += a.rgb * a.rgb;
      ++covered;
      ids[i] = int(texelFetch(surface_samples, corner + ivec2(i % kSide, i / kSide), 0).b * 255.0 + 0.5);
    }
  }
  if (covered == 0) {
    out_albedo = vec4(0.0);
    out_surface = vec4(128.0 / 255.0, 128.0 / 255.0, 0.0, 128.0 / 255.0);
    return;
  }
  int most = 0;
  int id = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    if (ids[i] < 0 || ids[i] == id && most > 0) continue;
    int same = 0;
    for (int k = 0; k < kSide * kSide; ++k) same += ids[k] == ids[i] ? 1 : 0;
    if (same > most) {
      most = same;
      id = ids[i];
    }
  }
  vec3 normal = vec3(0.0);
  float depth = 0.0;
  for (int i = 0; i < kSide * kSide; ++i) {
    if (ids[i] != id) continue;
    vec4 s = texelFetch(surface_samples, corner + ivec2(i % kSide, i / kSide), 0);
    vec2 n = (s.rg * 255.0 - 128.0) / 127.0;
    normal += vec3(n, sqrt(max(0.0, 1.0 - dot(n, n))));
    depth += s.a;
  }
  normal = normalize(normal + vec3(0.0, 0.0, 1e-6));
  out_albedo = vec4(sqrt(colour / float(covered)), float(covered) / float(kSide * kSide));
  out_surface = vec4((normal.xy * 127.0 + 128.0) / 255.0, float(id) / 255.0, depth / float(most));
}
