layout(binding = 0) uniform sampler2DArray normals_texture;
layout(binding = 1) uniform sampler2DArray validity_texture;
layout(binding = 2) uniform sampler2DArray drape_texture;

// Level-0 texels from the eye's texel, and what a pixel spans of them.
struct Footprint {
  vec2 at;
  float span_log2;
};

// Texture coordinate of the point in a level's layer. Beyond the raster its edge texel repeats.
vec3 layer_coordinate(int which, vec2 at, float level) {
  float cell = exp2(level);
  // Half a texel, and what hardware rounds coordinates by: no neighbour beyond the edge is read.
  vec2 low = 0.504 * cell - clips[which].size.zw;
  vec2 high = (ceil(clips[which].size.xy / cell) - 0.504) * cell - clips[which].size.zw;
  vec2 inside = clamp(at, low, max(low, high));
  vec2 origin = clips[which].origin[int(level)].xy;
  return vec3(origin + inside * (clips[which].scale.zw / cell), level - clips[which].levels.x);
}

// The finest level that a pixel can show and whose window surely holds the point, as a real number.
float clip_level(int which, Footprint f) {
  vec2 d = abs(f.at - clips[which].centre.xy);
  float reach = log2(max(max(d.x, d.y), 1.0) / clips[which].scale.y);
  float level = max(f.span_log2, min(reach, clips[which].levels.z));
  return clamp(level, clips[which].levels.y, clips[which].levels.w);
}

Footprint footprint(int which, vec2 posts, vec2 posts_dx, vec2 posts_dy) {
  float texels = clips[which].scale.x;
  // Geometric mean of the two axes: sharper at grazing angles than the longer axis alone.
  float area = length(posts_dx) * length(posts_dy) * texels * texels;
  return Footprint(posts * texels, 0.5 * log2(max(area, 1e-12)));
}

vec4 clip_fetch(int which, sampler2DArray tex, Footprint f) {
  float level = clip_level(which, f);
  float fine = floor(level);
  float coarse = min(fine + 1.0, clips[which].levels.w);
  return mix(textureLod(tex, layer_coordinate(which, f.at, fine), 0.0),
             textureLod(tex, layer_coordinate(which, f.at, coarse), 0.0), level - fine);
}

// At level 0 a cell shows when its four posts are valid; beyond, by coverage.
bool is_valid(Footprint f) {
  float level = clip_level(1, f);
  if (level < 0.5 && clips[1].levels.x == 0.0) {
    vec4 four = textureGather(validity_texture, layer_coordinate(1, f.at, 0.0));
    return min(min(four.x, four.y), min(four.z, four.w)) > 0.5;
  }
  return clip_fetch(1, validity_texture, f).r >= 0.5;
}
