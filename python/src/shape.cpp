// SPDX-License-Identifier: Apache-2.0
#include "common.hpp"

namespace meltsim_python {

using meltsim::Shape;

namespace {

std::vector<Shape> shapes(const std::string& name, const nb::args& parts) {
  std::vector<Shape> list;
  for (nb::handle part : parts) {
    if (!nb::isinstance<Shape>(part)) wrong_type(name + ": expected shapes, got " + shown(part));
    list.push_back(nb::cast<Shape>(part));
  }
  return list;
}

/// What cannot be sampled is refused where it is made.
Shape valid(Shape shape) {
  expect(shape.validate());
  return shape;
}

}  // namespace

void bind_shape(nb::module_& m) {
  nb::class_<Shape>(m, "Shape",
                    "A part of space [m]. Immutable. `a | b`, `a - b`, `a & b` unite, subtract, intersect.")
      .def_static(
          "box",
          [](Vector min, Vector max) { return valid(Shape::box(vector("min", min), vector("max", max))); },
          "min"_a, "max"_a, "Axis-aligned box between two corners.")
      .def_static(
          "sphere",
          [](Vector center, Real radius) {
            return valid(Shape::sphere(vector("center", center), number("radius", radius)));
          },
          "center"_a, "radius"_a, "Ball.")
      .def_static(
          "capsule",
          [](Vector a, Vector b, Real radius) {
            return valid(Shape::capsule(vector("a", a), vector("b", b), number("radius", radius)));
          },
          "a"_a, "b"_a, "radius"_a, "All points within `radius` of the segment from `a` to `b`.")
      .def_static(
          "cylinder",
          [](Vector a, Vector b, Real radius) {
            return valid(Shape::cylinder(vector("a", a), vector("b", b), number("radius", radius)));
          },
          "a"_a, "b"_a, "radius"_a, "Cylinder with flat ends at `a` and `b`.")
      .def_static(
          "torus",
          [](Vector center, Vector axis, Real major, Real minor) {
            return valid(Shape::torus(vector("center", center), vector("axis", axis),
                                      number("major_radius", major), number("minor_radius", minor)));
          },
          "center"_a, "axis"_a, "major_radius"_a, "minor_radius"_a, "Ring.")
      .def_static(
          "blend",
          [](ArrayLike centers, ArrayLike radii, Real blend) {
            const auto at = points("centers", centers), axes = points("radii", radii);
            if (at.size() != axes.size())
              refuse("radii: expected as many as centers, " + std::to_string(at.size()) + ", got " +
                     std::to_string(axes.size()));
            std::vector<meltsim::Ellipsoid> parts;
            for (std::size_t k = 0; k < at.size(); ++k) parts.push_back({at[k], axes[k]});
            return valid(Shape::blend(std::move(parts), number("blend", blend)));
          },
          "centers"_a, "radii"_a, "blend"_a = 0.0,
          "Smooth union of ellipsoids along the axes: centers and half axes (n, 3); neighbours merge over "
          "the "
          "width blend [m].")
      .def_static(
          "mesh",
          [](ArrayLike vertices, ArrayLike faces) {
            meltsim::TriangleMesh mesh;
            mesh.vertices = points("vertices", vertices);
            mesh.indices = triangles("triangles", faces);
            return valid(Shape::mesh(std::move(mesh)));
          },
          "vertices"_a, "triangles"_a,
          "Inside of a triangle mesh: vertices of shape (n, 3) [m] and indices of shape (m, 3), from 0.")
      .def_static(
          "from_file",
          [](Text path) { return valid(Shape::mesh(expect(meltsim::read_mesh(to_text(path))))); }, "path"_a,
          "Inside of the mesh of an OBJ, STL or PLY file.")
      .def_static(
          "unite", [](nb::args parts) { return Shape::unite(shapes("unite", parts)); },
          "Points in at least one part.")
      .def_static(
          "intersect", [](nb::args parts) { return Shape::intersect(shapes("intersect", parts)); },
          "Points in every part.")
      .def(
          "__or__",
          [](const Shape& a, const Shape& b) {
            return Shape::unite({a, b});
          },
          nb::is_operator())
      .def(
          "__and__",
          [](const Shape& a, const Shape& b) {
            return Shape::intersect({a, b});
          },
          nb::is_operator())
      .def(
          "__sub__", [](const Shape& a, const Shape& b) { return Shape::subtract(a, b); }, nb::is_operator())
      .def(
          "transformed",
          [](const Shape& s, Vector offset, Vector axis, Real angle, Real scale) {
            return valid(s.transformed(vector("offset", offset), vector("axis", axis), number("angle", angle),
                                       number("scale", scale)));
          },
          "offset"_a = nb::make_tuple(0, 0, 0), "axis"_a = nb::make_tuple(0, 1, 0), "angle"_a = 0.0,
          "scale"_a = 1.0,
          "The shape moved: x -> scale R x + offset, R = rotation about `axis` by `angle` [rad].")
      .def(
          "contains", [](const Shape& s, Vector point) { return s.contains(vector("point", point)); },
          "point"_a, "Whether the point [m] is inside.")
      .def_prop_ro(
          "bounds",
          [](const Shape& s) {
            const auto b = s.bounds();
            return nb::make_tuple(tuple3(b.min), tuple3(b.max));
          },
          "Smallest box around it: lower and upper corner [m].")
      .def("__repr__", [](const Shape& s) {
        if (s.empty()) return std::string("<meltsim.Shape: empty>");
        const auto b = s.bounds();
        return "<meltsim.Shape within " +
               std::string(nb::repr(nb::make_tuple(tuple3(b.min), tuple3(b.max))).c_str()) + ">";
      });
}

}  // namespace meltsim_python
