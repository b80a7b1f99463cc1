layout(binding = 3) uniform sampler1D tint_texture;
layout(binding = 4) uniform sampler2D grain_texture;

#ifdef WIREFRAME
in vec2 posts;
in vec3 from_eye;
in float height;
in vec3 corner;
#else
in vec2 v_posts;
in vec3 v_from_eye;
in float v_height;
#define posts v_posts
#define from_eye v_from_eye
#define height v_height
#endif

out vec4 colour;

// core/normal_code.h: v = sign(c) c^2, c in -1..1.
vec3 decode_normal(vec2 code) {
  vec2 root = code * 2.0 - 1.0;
  vec2 v = root * abs(root);
  return vec3(v, sqrt(max(1e-6, 1.0 - dot(v, v))));
}

vec3 land_normal(vec2 posts_dx, vec2 posts_dy) {
  if (has.x == 0) return normalize(cross(dFdx(from_eye), dFdy(from_eye)));
  Footprint f = footprint(0, posts, posts_dx, posts_dy);
  return decode_normal(clip_fetch(0, normals_texture, f).rg);
}

// Steeper slopes for the eye where a wide, low land would look flat.
vec3 shading_normal(vec3 n) { return normalize(vec3(n.xy * sun.w, max(n.z, 0.05))); }

vec3 ground_colour(vec3 n, vec2 posts_dx, vec2 posts_dy) {
  if (has.z != 0) {
    return clip_fetch(2, drape_texture, footprint(2, posts, posts_dx, posts_dy)).rgb;
  }
  // A noise, coarse and fine, gives the ground its grain and frays the bands of the tint.
  vec2 at = (posts + grain_origin.xy) * grain_origin.z;
  float fine = texture(grain_texture, at * 11.0).r - 0.5;
  float grain = texture(grain_texture, at).r - 0.5 + 0.6 * fine;
  float t = (height - tint.x) * tint.y;
  vec3 base = texture(tint_texture, t < tint.z ? t : max(t + 0.04 * grain, tint.z + 0.002)).rgb;
  if (t < tint.z) return base;
  vec3 rock = mix(vec3(0.11, 0.092, 0.076), vec3(0.165, 0.155, 0.145), clamp(t, 0.0, 1.0));
  float steep = smoothstep(0.14, 0.42, 1.0 - n.z + 0.12 * grain);
  if (has.w != 0) return base * (1.0 + 0.35 * grain) * (1.0 - 0.12 * steep);
  steep *= 1.0 - 0.5 * smoothstep(0.8, 0.95, t);  // snow stays on steep ground too
  return mix(base, rock, 0.85 * steep) * (1.0 + 0.55 * grain);
}

vec3 lit(vec3 albedo, vec3 n) {
  float direct = max(dot(n, sun.xyz), 0.0);
  float up = 0.5 + 0.5 * n.z;
  vec3 ground = vec3(0.10, 0.092, 0.084);
  vec3 ambient = mix(ground, mix(ground, vec3(0.19, 0.24, 0.32), sky_zenith.w), up * up);
  return albedo * (kSunlight * (1.9 * direct) + ambient);
}

#ifdef WIREFRAME
// 1 on an edge, 0 a pixel away from it; fades where triangles are smaller than a few pixels.
float edge_share() {
  vec3 width = max(fwidth(corner), 1e-6);
  vec3 distance_px = corner / width;
  float nearest = min(distance_px.x, min(distance_px.y, distance_px.z));
  float crowding = clamp(0.25 / max(width.x, max(width.y, width.z)), 0.15, 1.0);
  return (1.0 - smoothstep(0.2, 1.2, nearest)) * crowding;
}
#endif

void main() {
  vec2 posts_dx = dFdx(posts);
  vec2 posts_dy = dFdy(posts);
#ifdef MASK
  if (!is_valid(footprint(1, posts, posts_dx, posts_dy))) discard;
#endif
  vec3 n = shading_normal(land_normal(posts_dx, posts_dy));
  vec3 light = lit(ground_colour(n, posts_dx, posts_dy), n);
  vec3 direction = normalize(from_eye);
  vec3 seen = mix(sky_colour(vec3(direction.xy, max(direction.z, 0.02))), light,
                  transmittance(from_eye));
#ifdef WIREFRAME
  seen = mix(seen, vec3(0.012, 0.016, 0.03), 0.8 * edge_share());
#endif
  colour = vec4(display(seen), 1.0);
}
