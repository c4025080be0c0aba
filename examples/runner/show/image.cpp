// SPDX-License-Identifier: Apache-2.0
#include "show/image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace runner {

namespace {

/// Rows from the top, one bit a pixel, the leftmost in bit 4.
struct Glyph {
  char letter;
  std::uint8_t row[7];
};

constexpr Glyph glyphs[] = {
    {'0', {14, 17, 19, 21, 25, 17, 14}}, {'1', {4, 12, 4, 4, 4, 4, 14}},
    {'2', {14, 17, 1, 2, 4, 8, 31}},     {'3', {31, 2, 4, 2, 1, 17, 14}},
    {'4', {2, 6, 10, 18, 31, 2, 2}},     {'5', {31, 16, 30, 1, 1, 17, 14}},
    {'6', {6, 8, 16, 30, 17, 17, 14}},   {'7', {31, 1, 2, 4, 8, 8, 8}},
    {'8', {14, 17, 17, 14, 17, 17, 14}}, {'9', {14, 17, 17, 15, 1, 2, 12}},
    {'-', {0, 0, 0, 14, 0, 0, 0}},       {'+', {0, 4, 4, 31, 4, 4, 0}},
    {'.', {0, 0, 0, 0, 0, 12, 12}},      {',', {0, 0, 0, 0, 12, 4, 8}},
    {'=', {0, 0, 31, 0, 31, 0, 0}},      {':', {0, 12, 12, 0, 12, 12, 0}},
    {'%', {24, 25, 2, 4, 8, 19, 3}},     {'/', {0, 1, 2, 4, 8, 16, 0}},
    {'(', {2, 4, 8, 8, 8, 4, 2}},        {')', {8, 4, 2, 2, 2, 4, 8}},
    {'C', {14, 17, 16, 16, 16, 17, 14}}, {'^', {12, 18, 18, 12, 0, 0, 0}},  // the sign of degrees
    {'a', {0, 0, 14, 1, 15, 17, 15}},    {'b', {16, 16, 22, 25, 17, 17, 30}},
    {'c', {0, 0, 14, 16, 16, 17, 14}},   {'d', {1, 1, 13, 19, 17, 17, 15}},
    {'e', {0, 0, 14, 17, 31, 16, 14}},   {'f', {6, 9, 8, 28, 8, 8, 8}},
    {'g', {0, 15, 17, 17, 15, 1, 14}},   {'h', {16, 16, 22, 25, 17, 17, 17}},
    {'i', {4, 0, 12, 4, 4, 4, 14}},      {'j', {2, 0, 6, 2, 2, 18, 12}},
    {'k', {16, 16, 18, 20, 24, 20, 18}}, {'l', {12, 4, 4, 4, 4, 4, 14}},
    {'m', {0, 0, 26, 21, 21, 21, 21}},   {'n', {0, 0, 22, 25, 17, 17, 17}},
    {'o', {0, 0, 14, 17, 17, 17, 14}},   {'p', {0, 0, 30, 17, 30, 16, 16}},
    {'q', {0, 0, 13, 19, 15, 1, 1}},     {'r', {0, 0, 22, 25, 16, 16, 16}},
    {'s', {0, 0, 14, 16, 14, 1, 30}},    {'t', {8, 8, 28, 8, 8, 9, 6}},
    {'u', {0, 0, 17, 17, 17, 19, 13}},   {'v', {0, 0, 17, 17, 17, 10, 4}},
    {'w', {0, 0, 17, 17, 21, 21, 10}},   {'x', {0, 0, 17, 10, 4, 10, 17}},
    {'y', {0, 0, 17, 17, 15, 1, 14}},    {'z', {0, 0, 31, 2, 4, 8, 31}},
};

constexpr Rgb ink{0.10, 0.12, 0.16};

void fill(Image& image, int x, int y, int w, int h, const Rgb& color) {
  for (int j = y; j < y + h; ++j) {
    for (int i = x; i < x + w; ++i) image.set(i, j, color);
  }
}

/// Letters are this many times their 5 x 7 pixels.
int text_size(const Image& image) { return std::max(1, image.height / 270); }

}  // namespace

void Image::set(int x, int y, const Rgb& color) {
  if (x < 0 || y < 0 || x >= width || y >= height) return;
  std::uint8_t* pixel = at(x, y);
  for (std::size_t k = 0; k < 3; ++k)
    pixel[k] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(color[k], 0.0, 1.0)));
}

int text_width(const std::string& text, int size) { return 6 * size * static_cast<int>(text.size()) - size; }

void draw_text(Image& image, int x, int y, const std::string& text, int size, const Rgb& color) {
  for (const char letter : text) {
    for (const Glyph& glyph : glyphs) {
      if (glyph.letter != letter) continue;
      for (int row = 0; row < 7; ++row) {
        for (int column = 0; column < 5; ++column) {
          if ((glyph.row[row] >> (4 - column) & 1) != 0)
            fill(image, x + column * size, y + row * size, size, size, color);
        }
      }
    }
    x += 6 * size;
  }
}

std::string legend_number(double value) {
  return std::fabs(value) < 999.5 || std::fabs(value) > 1e6 ? fmt::format("{:.3g}", value)
                                                            : fmt::format("{:.0f}", value);
}

void draw_legend(Image& image, double cold, double hot) {
  const int size = text_size(image), margin = 10 * size,
            length = std::min(150 * size, image.width - 2 * margin);
  const int top = image.height - margin - 18 * size;
  for (int i = 0; i < length; ++i) {
    fill(image, margin + i, top, 1, 8 * size, ramp(static_cast<double>(i) / std::max(1, length - 1)));
  }
  for (int tick = 0; tick < 3; ++tick) {
    const std::string text = legend_number(cold + (hot - cold) * 0.5 * tick) + (tick == 2 ? " ^C" : "");
    const int x = margin + tick * (length - text_width(text, size)) / 2;
    draw_text(image, x, top + 11 * size, text, size, ink);
  }
}

void draw_caption(Image& image, const std::string& text) {
  const int size = text_size(image);
  draw_text(image, 10 * size, 10 * size, text, size, ink);
}

Image reduced(const Image& image, int width) {
  const int w = std::min(width, image.width), h = std::max(1, image.height * w / std::max(1, image.width));
  Image small(w, h);
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      const int x0 = x * image.width / w, x1 = std::max(x0 + 1, (x + 1) * image.width / w);
      const int y0 = y * image.height / h, y1 = std::max(y0 + 1, (y + 1) * image.height / h);
      int sum[3] = {0, 0, 0};
      for (int j = y0; j < y1; ++j) {
        for (int i = x0; i < x1; ++i) {
          const std::size_t from = 3 * (static_cast<std::size_t>(j) * static_cast<std::size_t>(image.width) +
                                        static_cast<std::size_t>(i));
          for (std::size_t k = 0; k < 3; ++k) sum[k] += image.rgb[from + k];
        }
      }
      const int n = (x1 - x0) * (y1 - y0);
      for (int k = 0; k < 3; ++k) small.at(x, y)[k] = static_cast<std::uint8_t>((sum[k] + n / 2) / n);
    }
  }
  return small;
}

Image contact_sheet(const std::vector<Image>& pictures, int columns, int width) {
  if (pictures.empty()) return {};
  const Image first = reduced(pictures.front(), width);
  const int gap = 4, rows = (static_cast<int>(pictures.size()) + columns - 1) / columns;
  Image sheet(columns * (first.width + gap) + gap, rows * (first.height + gap) + gap, 255);
  for (std::size_t n = 0; n < pictures.size(); ++n) {
    Image small = reduced(pictures[n], width);
    const int left = gap + static_cast<int>(n) % columns * (first.width + gap);
    const int top = gap + static_cast<int>(n) / columns * (first.height + gap);
    for (int y = 0; y < small.height; ++y)
      std::copy_n(small.at(0, y), 3 * small.width, sheet.at(left, top + y));
  }
  return sheet;
}

}  // namespace runner
