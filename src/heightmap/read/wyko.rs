use super::ReadOptions;
use crate::error::Fault;
use crate::heightmap::RawMap;
pub const NAME: &str = "wyko";
pub fn recognises(_b: &[u8]) -> bool {
    false
}
pub fn read(_b: &[u8], _o: &ReadOptions) -> Result<RawMap, Fault> {
    Err(Fault::NotThisFormat(NAME))
}
