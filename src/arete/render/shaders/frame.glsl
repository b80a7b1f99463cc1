// What every stage knows of the frame; mirrors FrameBlock in frame_block.h.
struct Clip {
  vec4 scale;       // texels per post; half the reach in texels; 1 / texture width, 1 / height
  vec4 levels;      // finest held, finest ready, finest held whole, coarsest
  vec4 size;        // level-0 texels: width, height; the eye's texel
  vec4 centre;      // of the windows, in texels from the eye
  vec4 origin[20];  // by level: texture coordinate of the eye's post
};

layout(std140, binding = 0) uniform FrameBlock {
  mat4 clip_from_camera;
  mat4 camera_from_clip;  // directions only: of the far plane
  vec4 plan;              // metres per post: x by col, x by row, y by col, y by row
  vec4 eye_offset;        // the eye's post from the eye (x, y); the eye's height, high and low part
  ivec4 eye_post;
  vec4 sun;          // unit direction; w = gain of the slopes in the shading
  vec4 tint;         // z_min, 1 / range, sea level in 0..1 or -1, spacing in metres
  vec4 haze;         // optical depth per metre at z_min, 1 / scale height, eye above z_min, -
  vec4 sky_zenith;   // linear light; w = how much the sky lights the land, 0..1
  vec4 sky_horizon;
  vec4 grain_origin; // the eye's post in turns of the grain; turns per post
  ivec4 has;         // normals, validity, drape; w: the tint is bare rock
  Clip clips[3];     // in the same order
};
