// What the debug views show.
vec3 heat(float t) { return clamp(vec3(1.5 - abs(4.0 * t - 3.0), 1.5 - abs(4.0 * t - 2.0), 1.5 - abs(4.0 * t - 1.0)), 0.0, 1.0); }
vec3 heat_of_taps() { return heat(min(float(taps) / 64.0, 1.0)); }  // dark red: 64 taps and more

// Writes what a view shows whatever the ray met, or where it met nothing; false: it shows the hit.
bool shown_instead(Hit hit, float anchor_depth) {
#if DEBUG == RELIEF_DEBUG_BOXES
  gl_FragDepth = stored_depth(anchor_depth);
  write_output(0.5 + 0.5 * cos(6.2831853 * (float(v_identity.z) * 0.381966 + vec3(0.0, 0.33, 0.67))), v_identity.y);
  return true;
#elif DEBUG == RELIEF_DEBUG_MISSES
  if (hit.depth < 0.0) {
    gl_FragDepth = stored_depth(anchor_depth);
    write_output(vec3(0.8, 0.05, 0.05), 0u);
    return true;
  }
#elif DEBUG == RELIEF_DEBUG_STEPS
  // Rays that meet nothing cost too: they show where nothing else does.
  if (hit.depth < 0.0) {
    gl_FragDepth = stored_depth(1e6);
    write_output(heat_of_taps(), 0u);
    return true;
  }
#endif
  return false;
}

vec3 shown_of_hit(vec3 lit, Face face) {
#if DEBUG == RELIEF_DEBUG_STEPS
  return heat_of_taps();
#elif DEBUG == RELIEF_DEBUG_HIT_FACE
  return (face.axis == 0 ? vec3(1.0, 0.2, 0.2) : face.axis == 1 ? vec3(0.2, 1.0, 0.2) : vec3(0.2, 0.3, 1.0)) *
         (face.side == 0 ? 0.5 : 1.0);
#else
  return lit;
#endif
}
