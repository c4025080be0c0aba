// SPDX-License-Identifier: Apache-2.0
#include "screenshot.hpp"

#include <epoxy/gl.h>

#include <algorithm>

#include "files.hpp"
#include "show/image.hpp"

namespace view {

void save_screenshot(const std::string& file, const Viewport& viewport) {
  runner::Image image(viewport.width, viewport.height);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadBuffer(GL_BACK);
  glReadPixels(0, 0, viewport.width, viewport.height, GL_RGB, GL_UNSIGNED_BYTE, image.rgb.data());
  const auto row = 3 * static_cast<std::ptrdiff_t>(viewport.width);
  for (int y = 0; y < viewport.height / 2; ++y) {  // OpenGL's rows begin at the bottom
    const auto top = image.rgb.begin() + y * row,
               bottom = image.rgb.begin() + (viewport.height - 1 - y) * row;
    std::swap_ranges(top, top + row, bottom);
  }
  runner::write_file(file, runner::png_text(image));
}

}  // namespace view
