in vec3 v_direction;
out vec4 colour;

void main() {
  vec3 direction = normalize(v_direction);
  vec3 light = sky_colour(direction);
  // Below the horizon: the same haze, darkening downwards.
  light *= mix(0.72, 1.0, exp2(6.0 * min(direction.z, 0.0)));
  float disc = smoothstep(0.99985, 0.99996, dot(direction, sun.xyz));
  colour = vec4(display(light + kSunlight * (6.0 * disc)), 1.0);
}
