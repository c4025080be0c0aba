// SPDX-License-Identifier: Apache-2.0
#include "screenshot.hpp"

#include <epoxy/gl.h>

#include <cerrno>
#include <cstring>
#include <vector>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb_image_write.h>

#include "failure.hpp"

namespace view {

void save_screenshot(const std::string& file, const Viewport& viewport) {
  const auto row = 3 * static_cast<std::size_t>(viewport.width);
  std::vector<unsigned char> pixels(row * static_cast<std::size_t>(viewport.height));
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadBuffer(GL_BACK);
  glReadPixels(0, 0, viewport.width, viewport.height, GL_RGB, GL_UNSIGNED_BYTE, pixels.data());
  stbi_flip_vertically_on_write(1);  // OpenGL's rows begin at the bottom
  errno = 0;
  if (stbi_write_png(file.c_str(), viewport.width, viewport.height, 3, pixels.data(),
                     static_cast<int>(row)) != 0)
    return;
  throw runner::Failure(runner::ExitCode::io, file + ": cannot be written: " + std::strerror(errno));
}

}  // namespace view
