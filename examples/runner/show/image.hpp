// SPDX-License-Identifier: Apache-2.0
// A picture in memory, text on it, and PNG.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "show/ramp.hpp"

namespace runner {

struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  ///< rows from the top

  Image() = default;
  Image(int w, int h, std::uint8_t shade = 0)
      : width(w), height(h), rgb(3 * static_cast<std::size_t>(w) * static_cast<std::size_t>(h), shade) {}
  std::uint8_t* at(int x, int y) {
    return &rgb[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                     static_cast<std::size_t>(x))];
  }
  void set(int x, int y, const Rgb& color);  ///< nothing outside the picture
};

/// Digits, "-+.,=:%/()", space and small letters, 5 x 7 pixels each times `size`. (x, y) is the upper left.
void draw_text(Image& image, int x, int y, const std::string& text, int size, const Rgb& color);
int text_width(const std::string& text, int size);
/// Three digits, or all before the point.
std::string legend_number(double value);
/// The ramp with numbers at its ends and in the middle, at the lower left.
void draw_legend(Image& image, double cold, double hot);
void draw_caption(Image& image, const std::string& text);  ///< at the upper left
/// A grid of pictures, each reduced to `width` pixels.
Image contact_sheet(const std::vector<Image>& pictures, int columns, int width);
Image reduced(const Image& image, int width);

std::string png_text(const Image& image);  ///< a whole file
Image read_png(const std::string& path);

}  // namespace runner
