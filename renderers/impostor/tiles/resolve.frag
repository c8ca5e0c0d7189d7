#version 450 core
// Many samples a texel down to one: the fraction that is covered, the covered samples' mean colour in linear light, the
// material id that most of them have, and the mean normal and depth of the samples with that id; where the character
// glows, the mean of what the covered samples give off.
layout(binding = 0) uniform sampler2D albedo_samples;
layout(binding = 1) uniform sampler2D surface_samples;
#ifdef CB_EMISSIVE
layout(binding = 2) uniform sampler2D emission_samples;
#endif
layout(location = 0) out vec4 out_albedo;
layout(location = 1) out vec4 out_surface;
#ifdef CB_EMISSIVE
layout(location = 2) out vec4 out_emission;
#endif

const int kSide = CB_SAMPLES;

vec4 surface_at(ivec2 corner, int i) { return texelFetch(surface_samples, corner + ivec2(i % kSide, i / kSide), 0); }
int id_of(vec4 surface) { return int(surface.b * 255.0 + 0.5); }

void main() {
  ivec2 corner = ivec2(gl_FragCoord.xy) * kSide;
  vec3 colour = vec3(0.0);
  int covered = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    vec4 a = texelFetch(albedo_samples, corner + ivec2(i % kSide, i / kSide), 0);
    colour += a.rgb * a.rgb;  // zero where nothing was drawn
    covered += a.a > 0.5 ? 1 : 0;
  }
  out_albedo = vec4(0.0);
  out_surface = vec4(128.0 / 255.0, 128.0 / 255.0, 0.0, 128.0 / 255.0);
#ifdef CB_EMISSIVE
  out_emission = vec4(0.0);
#endif
  if (covered == 0) return;
#ifdef CB_EMISSIVE
  vec3 emission = vec3(0.0);
  for (int i = 0; i < kSide * kSide; ++i) {
    vec3 e = texelFetch(emission_samples, corner + ivec2(i % kSide, i / kSide), 0).rgb;
    emission += e * e;  // zero where nothing was drawn
  }
  out_emission = vec4(sqrt(emission / float(covered)), 1.0);
#endif

  // Samples that are not covered were cleared to zero in every channel; a covered one's alpha code never is zero.
  vec3 normal = vec3(0.0);
  float depth = 0.0;
  int low = 255;
  int high = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    vec4 s = surface_at(corner, i);
    if (s.a == 0.0) continue;
    vec2 n = (s.rg * 255.0 - 128.0) / 127.0;
    normal += vec3(n, sqrt(max(0.0, 1.0 - dot(n, n))));
    depth += s.a;
    low = min(low, id_of(s));
    high = max(high, id_of(s));
  }
  int id = low;
  int most = covered;
  if (low != high) {
    // Several materials: the one that most samples show, the lowest id of equals.
    most = 0;
    for (int i = 0; i < kSide * kSide; ++i) {
      vec4 s = surface_at(corner, i);
      if (s.a == 0.0) continue;
      int mine = id_of(s);
      int same = 0;
      for (int k = 0; k < kSide * kSide; ++k) {
        vec4 other = surface_at(corner, k);
        same += other.a > 0.0 && id_of(other) == mine ? 1 : 0;
      }
      if (same > most || same == most && mine < id) {
        most = same;
        id = mine;
      }
    }
    normal = vec3(0.0);
    depth = 0.0;
    for (int i = 0; i < kSide * kSide; ++i) {
      vec4 s = surface_at(corner, i);
      if (s.a == 0.0 || id_of(s) != id) continue;
      vec2 n = (s.rg * 255.0 - 128.0) / 127.0;
      normal += vec3(n, sqrt(max(0.0, 1.0 - dot(n, n))));
      depth += s.a;
    }
  }
  normal = normalize(normal + vec3(0.0, 0.0, 1e-6));
  out_albedo = vec4(sqrt(colour / float(covered)), float(covered) / float(kSide * kSide));
  out_surface = vec4((normal.xy * 127.0 + 128.0) / 255.0, float(id) / 255.0, depth / float(most));
}
