// A skinned vertex in 16 bytes: the place as three floats, and the unit normal as two signed 16-bit numbers.
// Based on: Z. Cigolle et al., "A survey of efficient representations for independent unit vectors" (2014), the
// octahedral map.

uint skinned_sign_bits(float v) { return floatBitsToUint(v) & 0x80000000u; }
// v with the sign of s, that of zero included.
float skinned_signed(float v, float s) { return uintBitsToFloat(floatBitsToUint(v) | skinned_sign_bits(s)); }

uvec4 skinned_record(vec3 position, vec3 normal) {
  vec3 n = normal / max(abs(normal.x) + abs(normal.y) + abs(normal.z), 1e-30);
  // The lower half folds over the edges of the upper one's square.
  vec2 folded = vec2(skinned_signed(1.0 - abs(n.y), n.x), skinned_signed(1.0 - abs(n.x), n.y));
  return uvec4(floatBitsToUint(position), packSnorm2x16(n.z >= 0.0 ? n.xy : folded));
}

vec3 skinned_position(uvec4 record) { return uintBitsToFloat(record.xyz); }

// Of unit length: what is interpolated between vertices leans towards the longer one.
vec3 skinned_normal(uvec4 record) {
  vec2 p = unpackSnorm2x16(record.w);
  float z = 1.0 - abs(p.x) - abs(p.y);
  float fold = max(-z, 0.0);
  return normalize(vec3(p.x >= 0.0 ? p.x - fold : p.x + fold, p.y >= 0.0 ? p.y - fold : p.y + fold, z));
}
