// The objects that rays look at one after the other. The numbers of a uniform are loaded once for all lanes, within loops as
// well; what it has no room for lies in a buffer.

//#if spheres
//#if few_spheres
@group(0) @binding(next) var<uniform> spheres: array<SphereRecord, N_SPHERES>;
//#else
@group(0) @binding(next) var<storage, read> spheres: array<SphereRecord>;
//#end
//#end
//#if planes
//#if few_planes
@group(0) @binding(next) var<uniform> planes: array<PlaneRecord, N_PLANES>;
//#else
@group(0) @binding(next) var<storage, read> planes: array<PlaneRecord>;
//#end
//#end
