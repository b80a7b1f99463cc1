layout(location = 0) in ivec2 post;
layout(location = 1) in vec4 heights;  // z and its three deltas
layout(location = 2) in ivec2 shift;   // dcol, drow
layout(location = 3) in uvec4 slot;

struct Draw {
  float factor[16];  // 13 are used
};
layout(std430, binding = 1) readonly buffer Draws { Draw draws[]; };

out vec2 v_posts;      // plan position in posts from the eye's post
out vec3 v_from_eye;   // metres
out float v_height;    // metres
out vec3 v_captured;   // plan offset in posts, height: transform feedback

invariant gl_Position;

float factor_of(uint s) { return s < 13u ? draws[gl_BaseInstanceARB].factor[s] : 0.0; }

void main() {
  // The order of core's morphed_z; `precise` forbids a fused multiply-add.
  precise float z = heights.x;
  z += heights.y * factor_of(slot.x);
  z += heights.z * factor_of(slot.y);
  z += heights.w * factor_of(slot.z);
  precise vec2 offset = vec2(shift) * factor_of(slot.x);
  vec2 posts = vec2(post - eye_post.xy) + offset;
  v_posts = posts;
  v_height = z;
  v_captured = vec3(offset, z);
  v_from_eye = vec3(plan.x * posts.x + plan.y * posts.y + eye_offset.x,
                    plan.z * posts.x + plan.w * posts.y + eye_offset.y,
                    (z - eye_offset.z) - eye_offset.w);
  gl_Position = clip_from_camera * vec4(v_from_eye, 1.0);
}
