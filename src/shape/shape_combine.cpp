// SPDX-License-Identifier: Apache-2.0
// Union, difference and intersection. All flatten what they are given, so that shapes put together piece by piece in a
// loop stay shallow.
#include "shape/shape_combine.hpp"

#include <algorithm>

#include "shape/box_ops.hpp"
#include "shape/shape_check.hpp"

namespace meltsim {
inline namespace v0 {
namespace {

Status within(const std::string& where, const Status& inner) {
  if (inner) return {};
  Error e = inner.error();
  e.message = where + ": " + e.message;
  return e;
}

int deepest(const std::vector<ShapePtr>& parts) {
  int depth = 0;
  for (const ShapePtr& p : parts) depth = maximum(depth, p->depth());
  return depth;
}

bool any_holds_mesh(const std::vector<ShapePtr>& parts) {
  return std::any_of(parts.begin(), parts.end(), [](const ShapePtr& p) { return p->holds_mesh(); });
}

class UnionNode final : public ShapeNode {
 public:
  explicit UnionNode(std::vector<ShapePtr> parts) : ShapeNode(deepest(parts) + 1), parts_(std::move(parts)) {}

  const std::vector<ShapePtr>& parts() const { return parts_; }

  bool holds_mesh() const override { return any_holds_mesh(parts_); }
  bool contains(Vec3d p) const override {
    for (const ShapePtr& part : parts_)
      if (part->contains(p)) return true;
    return false;
  }

  Box bounds(const Affine& to_world) const override {
    Box out = empty_box();
    for (const ShapePtr& part : parts_) grow(out, part->bounds(to_world));
    return out;
  }

  Status validate() const override {
    for (std::size_t i = 0; i < parts_.size(); ++i)
      if (Status s = parts_[i]->validate(); !s) return within("unite.parts[" + std::to_string(i) + "]", s);
    return {};
  }

  void fill(const Lattice& lattice, SiteMask& mask) const override {
    for (const ShapePtr& part : parts_) combine(sample(*part, lattice, mask.range), 1, mask);
  }

  /// Writes `value` where `part` is inside.
  static void combine(const SiteMask& part, std::uint8_t value, SiteMask& mask) {
    const SiteRange& r = part.range;
    if (r.empty()) return;
    const auto offset = static_cast<std::size_t>(r.lo.x - mask.range.lo.x);
    for (std::int32_t z = r.lo.z; z < r.hi.z; ++z)
      for (std::int32_t y = r.lo.y; y < r.hi.y; ++y) {
        const std::uint8_t* from = part.inside.data() + part.row(y, z);
        std::uint8_t* to = mask.inside.data() + mask.row(y, z) + offset;
        for (std::size_t x = 0; x < r.width(); ++x)
          if (from[x] != 0) to[x] = value;
      }
  }

 private:
  std::vector<ShapePtr> parts_;
};

class DifferenceNode final : public ShapeNode {
 public:
  DifferenceNode(ShapePtr from, ShapePtr what)
      : ShapeNode(maximum(from->depth(), what->depth()) + 1),
        from_(std::move(from)),
        what_(std::move(what)) {}

  const ShapePtr& from() const { return from_; }
  const ShapePtr& what() const { return what_; }

  bool holds_mesh() const override { return from_->holds_mesh() || what_->holds_mesh(); }
  bool contains(Vec3d p) const override { return from_->contains(p) && !what_->contains(p); }
  Box bounds(const Affine& to_world) const override { return from_->bounds(to_world); }

  Status validate() const override {
    if (Status s = from_->validate(); !s) return within("subtract.from", s);
    return within("subtract.what", what_->validate());
  }

  void fill(const Lattice& lattice, SiteMask& mask) const override {
    from_->fill(lattice, mask);
    UnionNode::combine(sample(*what_, lattice, mask.range), 0, mask);
  }

 private:
  ShapePtr from_, what_;
};

class IntersectionNode final : public ShapeNode {
 public:
  explicit IntersectionNode(std::vector<ShapePtr> parts)
      : ShapeNode(deepest(parts) + 1), parts_(std::move(parts)) {}

  const std::vector<ShapePtr>& parts() const { return parts_; }

  bool holds_mesh() const override { return any_holds_mesh(parts_); }
  bool contains(Vec3d p) const override {
    for (const ShapePtr& part : parts_)
      if (!part->contains(p)) return false;
    return true;
  }

  Box bounds(const Affine& to_world) const override {
    Box out = parts_.front()->bounds(to_world);
    for (const ShapePtr& part : parts_) {
      const Box b = part->bounds(to_world);
      out.min = {maximum(out.min.x, b.min.x), maximum(out.min.y, b.min.y), maximum(out.min.z, b.min.z)};
      out.max = {minimum(out.max.x, b.max.x), minimum(out.max.y, b.max.y), minimum(out.max.z, b.max.z)};
    }
    return inverted(out) ? Box{out.min, out.min}
                         : out;  // parts that do not meet: a point, which holds nothing
  }

  Status validate() const override {
    for (std::size_t i = 0; i < parts_.size(); ++i)
      if (Status s = parts_[i]->validate(); !s)
        return within("intersect.parts[" + std::to_string(i) + "]", s);
    return {};
  }

  void fill(const Lattice& lattice, SiteMask& mask) const override {
    std::vector<std::uint8_t> missing(mask.inside.size(), 0);
    for (const ShapePtr& part : parts_) {
      SiteMask one{mask.range, std::vector<std::uint8_t>(mask.inside.size(), 0)};
      UnionNode::combine(sample(*part, lattice, mask.range), 1, one);
      for (std::size_t i = 0; i < missing.size(); ++i)
        if (one.inside[i] == 0) missing[i] = 1;
    }
    for (std::size_t i = 0; i < missing.size(); ++i) mask.inside[i] = missing[i] == 0 ? 1 : 0;
  }

 private:
  std::vector<ShapePtr> parts_;
};

}  // namespace

ShapePtr make_intersection(std::vector<ShapePtr> parts) {
  std::vector<ShapePtr> flat;
  for (ShapePtr& part : parts) {
    if (!part) return nullptr;  // nothing is in an empty shape
    if (const auto* inner = dynamic_cast<const IntersectionNode*>(part.get()))
      flat.insert(flat.end(), inner->parts().begin(), inner->parts().end());
    else flat.push_back(std::move(part));
  }
  if (flat.empty()) return nullptr;
  if (flat.size() == 1) return flat.front();
  return std::make_shared<IntersectionNode>(std::move(flat));
}

ShapePtr make_union(std::vector<ShapePtr> parts) {
  std::vector<ShapePtr> flat;
  for (ShapePtr& part : parts) {
    if (!part) continue;
    if (const auto* inner = dynamic_cast<const UnionNode*>(part.get()))
      flat.insert(flat.end(), inner->parts().begin(), inner->parts().end());
    else flat.push_back(std::move(part));
  }
  if (flat.empty()) return nullptr;
  if (flat.size() == 1) return flat.front();
  return std::make_shared<UnionNode>(std::move(flat));
}

ShapePtr make_difference(ShapePtr from, ShapePtr what) {
  if (!from || !what) return from;
  if (const auto* inner = dynamic_cast<const DifferenceNode*>(from.get()))
    return std::make_shared<DifferenceNode>(inner->from(), make_union({inner->what(), std::move(what)}));
  return std::make_shared<DifferenceNode>(std::move(from), std::move(what));
}

}  // namespace v0
}  // namespace meltsim
