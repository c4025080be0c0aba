// SPDX-License-Identifier: Apache-2.0
#include <png.h>

#include "failure.hpp"
#include "show/image.hpp"

namespace runner {

std::string png_text(const Image& image) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = 0;
  if (png_image_write_to_memory(&header, nullptr, &size, 0, image.rgb.data(), 0, nullptr) != 0) {
    std::string data(size, '\0');
    if (png_image_write_to_memory(&header, data.data(), &size, 0, image.rgb.data(), 0, nullptr) != 0) {
      data.resize(size);
      return data;
    }
  }
  throw Failure(ExitCode::io, std::string("a picture could not be packed as PNG: ") + header.message);
}

Image read_png(const std::string& path) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&header, path.c_str()) != 0) {
    header.format = PNG_FORMAT_RGB;
    Image image(static_cast<int>(header.width), static_cast<int>(header.height));
    if (png_image_finish_read(&header, nullptr, image.rgb.data(), 0, nullptr) != 0) return image;
  }
  throw Failure(ExitCode::io, path + ": cannot be read as PNG: " + header.message);
}

}  // namespace runner
