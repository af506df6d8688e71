// The library is beside the page: browsers know no packages.
export { forward } from "mgrs";
