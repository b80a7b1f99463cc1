// Linear light. One sun, a sky that pales towards the horizon, haze that takes its colour from it.
const vec3 kSunlight = vec3(1.0, 0.93, 0.80);

vec3 sky_colour(vec3 direction) {
  float up = max(direction.z, 0.0);
  float toward_sun = max(dot(direction, sun.xyz), 0.0);
  float pale = 0.75 * exp2(-5.0 * up) + 0.25 * exp2(-26.0 * up);
  float glow = toward_sun * toward_sun;
  glow *= glow;
  float core = glow * glow;
  core *= core;
  return mix(sky_zenith.rgb, sky_horizon.rgb, pale) +
         sky_zenith.w * kSunlight * (0.10 * glow + 0.30 * core * core) * (0.35 + 0.65 * pale);
}

// Share of the point's own light that reaches the eye, through air that thins exponentially.
float transmittance(vec3 from_eye) {
  float climb = from_eye.z * haze.y;
  float at_eye = exp(-max(haze.z * haze.y, -2.0));
  float mean = abs(climb) < 1e-3 ? 1.0 : (1.0 - exp(-clamp(climb, -40.0, 40.0))) / climb;
  return exp(-haze.x * length(from_eye) * at_eye * mean);
}

// Filmic curve with the display's gamma in it [Hejl-Burgess-Dawson], then half a step of ordered
// noise against banding.
vec3 display(vec3 linear) {
  vec3 x = max(linear - 0.004, 0.0);
  vec3 c = (x * (6.2 * x + 0.5)) / (x * (6.2 * x + 1.7) + 0.06);
  float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
  return c + (noise - 0.5) / 255.0;
}
